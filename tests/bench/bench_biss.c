/* SPDX-License-Identifier: MIT */
/*
 * How fast the S36 with BiSS is in virtual time.
 *
 * bench_biss                  edges and frames per second, one figure a line
 * bench_biss --callgrind N    exactly N frames of 36 bits by edges and nothing measured: the
 *                             instructions of an edge are the difference of two runs, divided by
 *                             the difference of N and by the edges of a frame
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"

#define SECONDS_EACH 1.0
#define BATCH 1000u
#define HALF_NS 50u /* 10 MHz */
#define DATA_BITS 36u
/* e1, e2, start, CDS, data: a falling and a rising edge each. */
#define EDGES (2u * (4u + DATA_BITS))

static struct biss_rig rig;
static uint64_t sum; /* keeps the work from being left out */

static double now_s(void)
{
    struct timespec t;

    (void)timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Called as a simulator would: an edge at a time, nothing in between. */
static void frame_by_edges(void)
{
    struct dg_biss *slave = &rig.slave[0];
    dg_ns now = rig.now;

    for (unsigned i = 0; i < EDGES; i++) {
        now += HALF_NS;
        sum += dg_biss_ma(slave, now, i % 2u != 0);
    }
    rig.now = now + DG_BISS_TIMEOUT_NS;
    (void)dg_biss_step(slave, rig.now);
}

static void frame_at_once(void)
{
    uint64_t bits = 0;

    rig.now += 20000;
    (void)dg_biss_frame(&rig.slave[0], rig.now, &bits);
    sum += bits;
    dg_biss_frame_end(&rig.slave[0], rig.now + DG_BISS_TIMEOUT_NS, false);
}

static double frames_per_s(void (*frame)(void))
{
    const double begin = now_s();
    uint64_t frames = 0;
    double elapsed;

    do {
        for (unsigned i = 0; i < BATCH; i++) {
            frame();
        }
        frames += BATCH;
        elapsed = now_s() - begin;
    } while (elapsed < SECONDS_EACH);
    return (double)frames / elapsed;
}

int main(int argc, char **argv)
{
    const bool counted = argc == 3 && strcmp(argv[1], "--callgrind") == 0;
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3684-biss"));

    if (argc != 1 && !counted) {
        (void)fprintf(stderr, "usage: bench_biss [--callgrind N]\n");
        return 2;
    }
    model.singleturn_bits = 16; /* 12 + 16 + 2 and CRC */
    model.life_counter = false;
    if (biss_rig_init(&rig, &model, 1) != DG_OK || biss_rig_power_on(&rig) != DG_OK) {
        return 1;
    }
    rig.angle_per_us = DG_TURN / 20000; /* 3000 rpm */
    if (counted) {
        for (unsigned long n = strtoul(argv[2], NULL, 10); n > 0; n--) {
            frame_by_edges();
        }
        return sum == 0 && strcmp(argv[2], "0") != 0;
    }
    const double edges = frames_per_s(frame_by_edges) * EDGES;
    (void)printf("%-40s %12.0f\n", "edges/s (aim: 100000000)", edges);
    (void)printf("%-40s %12.1f\n", "times faster than 10 MHz (aim: 5)", edges / 20e6);
    (void)printf("%-40s %12.0f\n", "frames/s at once", frames_per_s(frame_at_once));
    return sum == 0;
}
