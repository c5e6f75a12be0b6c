/* SPDX-License-Identifier: MIT */
/*
 * How fast a ring of K3 encoders is in virtual time, next to the cycle time that the formula gives
 * at 2 MBd, and what one costs in RAM.
 */
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "drehgeber/devices.h"
#include "ib_rig.h"

#define SECONDS_EACH 0.5
#define BATCH 64u

static struct dg_ib devices[DG_IB_RING_MAX];
static uint16_t out[2u * DG_IB_RING_MAX];
static uint16_t in[2u * DG_IB_RING_MAX];
static uint16_t ids[DG_IB_RING_MAX];
static struct ib_rig rig; /* its memory serves all: none of them stores anything here */

static double now_s(void)
{
    struct timespec t;

    (void)timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void must(int holds)
{
    if (!holds) {
        (void)fprintf(stderr, "bench_ib: the ring does not run\n");
        exit(1);
    }
}

static void measure(uint16_t count)
{
    struct dg_ib_ring ring;
    dg_ns now = DG_S(1);

    for (uint16_t i = 0; i < count; i++) {
        devices[i] = rig.device;
        must(dg_ib_power_on(&devices[i], 0) == DG_OK);
    }
    must(dg_ib_ring_init(&ring, devices, count) == DG_OK);
    must(dg_ib_ring_id(&ring, now, ids) == count);
    const dg_ns cycle = dg_ib_ring_cycle_time(&ring, 2000000, 0);
    const double begin = now_s();
    uint64_t cycles = 0;
    double elapsed;
    do {
        for (unsigned i = 0; i < BATCH; i++) {
            now += cycle;
            must(dg_ib_ring_cycle(&ring, now, out, in) == DG_IB_RING_OK);
        }
        cycles += BATCH;
        elapsed = now_s() - begin;
    } while (elapsed < SECONDS_EACH);
    const double rate = (double)cycles / elapsed;
    (void)printf("%-4u %12.0f %10.2f %14.0f\n", count, rate, (double)cycle / 1e3,
                 rate * (double)cycle / 1e9);
}

int main(void)
{
    static const uint16_t counts[] = {1, 16, 512};

    must(ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k3"))) == DG_OK);
    rig.angle_per_ms = DG_TURN / 20; /* 3000 rpm */
    (void)printf("K3        cycles/s  us at 2MBd  x real time\n");
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        measure(counts[i]);
    }
    (void)printf("bytes of a device (aim: 768)     %lu\n", (unsigned long)sizeof(struct dg_ib));
    (void)printf("bytes of its EEPROM              %lu\n",
                 (unsigned long)dg_store_size(&dg_ib_layout));
    return 0;
}
