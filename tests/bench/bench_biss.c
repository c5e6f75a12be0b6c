/* SPDX-License-Identifier: MIT */
/*
 * The S36 with BiSS at 10 MHz, called as a simulator would: an edge at a time, nothing in between.
 * One slave, three in a chain, and a whole frame at once. A figure by edges is one edge of the
 * wire.
 */
#include "bench.h"
#include "biss_rig.h"
#include "drehgeber/devices.h"
#include "drehgeber/motion.h"

#define HALF_NS 50u
#define SLAVES 3u
#define DATA_BITS 36u /* MT, ST, nERR and nWARN, CRC6 */
/* Rising edges: e1, e2, start, CDS, data; in a chain the start comes a clock later for each more.
 */
#define CLOCKS (4u + DATA_BITS)
#define CHAIN_CLOCKS (CLOCKS + (SLAVES - 1u) * (1u + DATA_BITS))

static struct biss_rig one, word, turning, three;
static struct dg_motion motion;
static struct dg_biss_chain chain;
static bool line[CLOCKS], chain_line[CHAIN_CLOCKS]; /* SL at the rising edges */
static uint64_t word_bits;

/* A shaft at constant speed that costs nothing: the slaves are measured, not the motion. */
static dg_angle angle(void *ctx, dg_ns at)
{
    (void)ctx;
    return (dg_angle)at;
}

static void by_edges(const void *what)
{
    struct dg_biss *slave = &one.slave[0];
    dg_ns now = one.now;

    (void)what;
    for (unsigned i = 0; i < CLOCKS; i++) {
        (void)dg_biss_ma(slave, now + HALF_NS, false);
        now += 2u * HALF_NS;
        line[i] = dg_biss_ma(slave, now, true);
    }
    one.now = now + DG_BISS_TIMEOUT_NS;
    (void)dg_biss_step(slave, one.now);
}

static void chain_by_edges(const void *what)
{
    dg_ns now = three.now;

    (void)what;
    for (unsigned i = 0; i < CHAIN_CLOCKS; i++) {
        (void)dg_biss_chain_ma(&chain, now + HALF_NS, false);
        now += 2u * HALF_NS;
        chain_line[i] = dg_biss_chain_ma(&chain, now, true);
    }
    three.now = now + DG_BISS_TIMEOUT_NS;
    (void)dg_biss_chain_step(&chain, three.now);
}

static void at_once(const void *what)
{
    struct biss_rig *const *of = what;
    struct biss_rig *rig = *of;

    rig->now += DG_US(20);
    (void)dg_biss_frame(&rig->slave[0], rig->now, &word_bits);
    dg_biss_frame_end(&rig->slave[0], rig->now + DG_BISS_TIMEOUT_NS, false);
}

static bool make(struct biss_rig *rig, uint8_t count)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3684-biss"));

    model.singleturn_bits = 16;
    model.life_counter = false;
    model.busy = 0; /* data is clocked, not waiting */
    if (biss_rig_init(rig, &model, count) != DG_OK || biss_rig_power_on(rig) != DG_OK) {
        return false;
    }
    rig->world.angle = angle;
    (void)biss_rig_frame(rig, false); /* SLO is low until the first one */
    return true;
}

static bool start_encoder(void)
{
    static const struct dg_motion wanted = {.kind = DG_MOTION_SPEED, .mrpm = 3000123};

    if (!make(&one, 1) || !make(&word, 1) || !make(&turning, 1) || !make(&three, SLAVES) ||
        dg_motion_set(&motion, &wanted) != DG_OK) {
        return false;
    }
    turning.now += DG_S(1000); /* a while after the start */
    turning.world.angle = dg_motion_angle;
    turning.world.angle_ctx = &motion;
    chain.count = SLAVES;
    for (unsigned i = 0; i < SLAVES; i++) {
        chain.slave[i] = &three.slave[i];
    }
    return true;
}

static bool is_right(const bool *bits)
{
    struct dg_biss_data data;
    uint64_t all = 0;

    for (unsigned i = 0; i < DATA_BITS; i++) {
        all = all << 1 | bits[i];
    }
    dg_biss_frame_decode(&one.model, all, &data);
    return data.crc_ok && data.n_err && data.n_warn;
}

/* Frames so far; 0 when the last ones are not what a master understands. */
static uint64_t answers(void)
{
    const uint64_t frames = one.slave[0].counters.frames + word.slave[0].counters.frames +
                            turning.slave[0].counters.frames +
                            three.slave[SLAVES - 1u].counters.frames;
    bool right = one.slave[0].counters.frames == 1 || is_right(&line[CLOCKS - DATA_BITS]);

    for (unsigned i = 1; i <= SLAVES && three.slave[0].counters.frames > 1; i++) {
        right = right && is_right(&chain_line[CHAIN_CLOCKS - i * DATA_BITS]);
    }
    return right ? frames : 0;
}

int main(int argc, char **argv)
{
    static struct biss_rig *const still = &word, *const moving = &turning;
    static const struct bench benches[] = {
        {"biss.edge", by_edges, NULL, 1, 2u * CLOCKS},
        {"biss.edge-of-chain-3", chain_by_edges, NULL, 1, 2u * CHAIN_CLOCKS},
        {"biss.frame-at-once", at_once, &still, 1, 1},
        {"biss.frame-at-once-turning", at_once, &moving, 1, 1},
    };
    static const struct bench_bytes bytes[] = {{"ram.dg_biss", sizeof(struct dg_biss)}};
    static const struct bench_set set = {.benches = benches,
                                         .count = DG_COUNT(benches),
                                         .bytes = bytes,
                                         .bytes_count = 1,
                                         .start = start_encoder,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}
