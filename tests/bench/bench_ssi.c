/* SPDX-License-Identifier: MIT */
/*
 * An SSI encoder (25 bit, Gray) at 1 MHz: an edge of the clock at a time, and a whole word at once.
 */
#include "bench.h"
#include "drehgeber/devices.h"
#include "ssi_rig.h"

#define HALF_NS 500u
#define BITS 25u
#define CLOCKS (BITS + 1u)

static struct ssi_rig rig;
static uint64_t words;
static uint64_t word; /* the last one */

/* A shaft at constant speed that costs nothing: the encoder is measured, not the motion. */
static dg_angle angle(void *ctx, dg_ns at)
{
    (void)ctx;
    return (dg_angle)at;
}

static void by_edges(const void *what)
{
    dg_ns now = rig.now;
    uint64_t bits = 0;

    (void)what;
    for (unsigned i = 0; i < CLOCKS; i++) {
        (void)dg_ssi_clock(&rig.device, now + HALF_NS, false);
        now += 2u * HALF_NS;
        bits = bits << 1 | dg_ssi_clock(&rig.device, now, true);
    }
    word = bits >> (CLOCKS - BITS);
    words++;
    rig.now = now + 2u * rig.model.monoflop;
    (void)dg_ssi_step(&rig.device, rig.now);
}

static void at_once(const void *what)
{
    (void)what;
    rig.now += DG_US(100);
    words += dg_ssi_frame(&rig.device, rig.now, &word) == BITS;
}

static bool start_encoder(void)
{
    if (ssi_rig_init(&rig, dg_ssi_model_of(dg_device_find("ssi-25"))) != DG_OK) {
        return false;
    }
    ssi_rig_power_on(&rig);
    rig.world.angle = angle;
    return true;
}

/* Words so far; 0 when the last one is not what a master expects. */
static uint64_t answers(void)
{
    const uint32_t position = (uint32_t)rig.device.position;

    return word == 0 || word == ssi_rig_word(&rig.model, position, false) ? words : 0;
}

int main(int argc, char **argv)
{
    static const struct bench benches[] = {
        {"ssi.edge", by_edges, NULL, 1, 2u * CLOCKS},
        {"ssi.word-at-once", at_once, NULL, 1, 1},
    };
    static const struct bench_bytes bytes[] = {{"ram.dg_ssi", sizeof(struct dg_ssi)}};
    static const struct bench_set set = {.benches = benches,
                                         .count = DG_COUNT(benches),
                                         .bytes = bytes,
                                         .bytes_count = 1,
                                         .start = start_encoder,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}
