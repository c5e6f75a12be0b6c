/* SPDX-License-Identifier: MIT */
/*
 * An encoder in a simulator: the loop of drehgeber_dpi.svh around it, which a master with 10 MHz
 * clocks. Frames are read, not only clocked. The library is the one that a simulator loads.
 */
#include "bench.h"
#include "drehgeber/bits.h"
#include "hdl.h"

#define HALF_CLOCK_PS INT64_C(50000)
#define PAUSE_PS INT64_C(20000000)
#define CLOCKS 44u
#define EDGES (2u * CLOCKS)
#define BEHIND_POSITION 8u /* two flags and the CRC */
#define WAKES_MAX 8u

static struct dg_hdl *encoder;
static int64_t now_ps;
static int64_t wakes[WAKES_MAX]; /* the earliest one is the last */
static size_t wake_count;
static int outputs;
static uint64_t answered;

static void look_at_line(int64_t at, int inputs)
{
    while (wake_count > 0 && wakes[wake_count - 1u] <= at) {
        wake_count--;
    }
    outputs = dg_hdl_wires(encoder, at, inputs);
    const int64_t due = dg_hdl_next(encoder);
    if (due >= 0 && (wake_count == 0 || due < wakes[wake_count - 1u]) && wake_count < WAKES_MAX) {
        wakes[wake_count++] = due;
    }
}

static void pass_time(int64_t ps, int inputs)
{
    const int64_t until = now_ps + ps;

    while (wake_count > 0 && wakes[wake_count - 1u] < until) {
        look_at_line(wakes[wake_count - 1u], inputs);
    }
    now_ps = until;
}

/* Bits are taken when the clock falls. */
static void read_frame(const void *what)
{
    uint64_t bits = 0;

    (void)what;
    for (unsigned clock = 0; clock < CLOCKS; clock++) {
        look_at_line(now_ps, 0);
        pass_time(HALF_CLOCK_PS, 0);
        look_at_line(now_ps, DG_HDL_CLOCK);
        pass_time(HALF_CLOCK_PS, DG_HDL_CLOCK);
        bits = bits << 1 | ((outputs & DG_HDL_DATA) != 0 ? 1u : 0u);
    }
    pass_time(PAUSE_PS, DG_HDL_CLOCK);
    answered += (uint32_t)(bits >> BEHIND_POSITION) == (uint64_t)dg_hdl_latched(encoder);
}

static const struct bench benches[] = {{"hdl.edge", read_frame, NULL, 1, EDGES}};

static bool start_encoder(void)
{
    encoder = dg_hdl_open("s3684-biss", "mt=12 st=20 lc=0 busy_us=0", "3000RPM", "");
    look_at_line(0, DG_HDL_CLOCK);
    pass_time(PAUSE_PS, DG_HDL_CLOCK);
    return dg_hdl_error(encoder)[0] == '\0';
}

static uint64_t answers(void)
{
    return answered;
}

int main(int argc, char **argv)
{
    static const struct bench_set set = {
        .benches = benches, .count = DG_COUNT(benches), .start = start_encoder, .answers = answers};

    return bench_main(argc, argv, &set);
}
