/* SPDX-License-Identifier: MIT */
/*
 * Where a shaft is at a moment: what every latch asks first.
 */
#include "bench.h"
#include "drehgeber/hal.h"
#include "drehgeber/motion.h"
#include "drehgeber/shaft.h"

#define PERIOD DG_US(250)

static struct dg_motion speed, ramp, sine;
static struct dg_shaft shaft;
static dg_ns now = DG_S(1000); /* a while after the start */
static uint64_t asked;
static volatile dg_angle at;

static void motion(const void *what)
{
    struct dg_motion *const *motion = what;

    now += PERIOD;
    at = dg_motion_angle(*motion, now);
    asked++;
}

static void steered(const void *what)
{
    (void)what;
    now += PERIOD;
    at = dg_shaft_angle(&shaft, now);
    asked++;
}

static bool start_shafts(void)
{
    const struct dg_motion wanted[] = {
        {.kind = DG_MOTION_SPEED, .mrpm = 3000123},
        {.kind = DG_MOTION_RAMP, .mrpm = 3000123, .accel = DG_MOTION_RAMP_MAX, .hold = DG_NEVER},
        {.kind = DG_MOTION_SINE, .amplitude = DG_TURN / 3, .period = DG_MS(777)},
    };

    dg_shaft_init(&shaft);
    return dg_motion_set(&speed, &wanted[0]) == DG_OK &&
           dg_motion_set(&ramp, &wanted[1]) == DG_OK && dg_motion_set(&sine, &wanted[2]) == DG_OK &&
           dg_shaft_set_velocity(&shaft, 0, 3000123) == DG_OK;
}

static uint64_t answers(void)
{
    return asked;
}

int main(int argc, char **argv)
{
    static struct dg_motion *const turning = &speed, *const starting = &ramp,
                                   *const swinging = &sine;
    static const struct bench benches[] = {
        {"shaft.speed", motion, &turning, 1, 1},
        {"shaft.ramp", motion, &starting, 1, 1},
        {"shaft.sine", motion, &swinging, 1, 1},
        {"shaft.steered", steered, NULL, 1, 1},
    };
    static const struct bench_bytes bytes[] = {
        {"ram.dg_motion", sizeof(struct dg_motion)},
        {"ram.dg_shaft", sizeof(struct dg_shaft)},
    };
    static const struct bench_set set = {.benches = benches,
                                         .count = DG_COUNT(benches),
                                         .bytes = bytes,
                                         .bytes_count = DG_COUNT(bytes),
                                         .start = start_shafts,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}
