/* SPDX-License-Identifier: MIT */
/*
 * Rings of K3 encoders: a data cycle of one, and of many, for each of them.
 */
#include "bench.h"
#include "drehgeber/devices.h"
#include "drehgeber/interbus.h"
#include "ram_nvm.h"

#define SMALL 1u
#define LARGE 64u
#define BAUD 2000000u

struct subject {
    struct dg_ib devices[LARGE];
    struct dg_ib_ring ring;
    uint16_t out[2u * LARGE];
    uint16_t in[2u * LARGE];
    dg_ns now;
    dg_ns cycle;
};
static struct subject small, large;
static struct ram_nvm nvm; /* serves all: none of them stores anything here */
static struct dg_world world;
static uint64_t whole;

/* A shaft at constant speed that costs nothing: the encoders are measured, not the motion. */
static dg_angle angle(void *ctx, dg_ns at)
{
    (void)ctx;
    return (dg_angle)at;
}

static void cycle_small(const void *what)
{
    (void)what;
    small.now += small.cycle;
    whole += dg_ib_ring_cycle(&small.ring, small.now, small.out, small.in) == DG_IB_RING_OK;
}

static void cycle_large(const void *what)
{
    (void)what;
    large.now += large.cycle;
    whole += dg_ib_ring_cycle(&large.ring, large.now, large.out, large.in) == DG_IB_RING_OK;
}

static bool make(struct subject *self, uint16_t count)
{
    const struct dg_ib_setup setup = {.model = dg_ib_model_of(dg_device_find("ocd-ib-k3")),
                                      .world = &world,
                                      .nvm = ram_nvm_port(&nvm)};
    uint16_t ids[LARGE];

    self->now = DG_S(1);
    for (uint16_t i = 0; i < count; i++) {
        if (dg_ib_init(&self->devices[i], &setup) != DG_OK ||
            dg_ib_power_on(&self->devices[i], 0) != DG_OK) {
            return false;
        }
    }
    if (dg_ib_ring_init(&self->ring, self->devices, count) != DG_OK ||
        dg_ib_ring_id(&self->ring, self->now, ids) != count) {
        return false;
    }
    self->cycle = dg_ib_ring_cycle_time(&self->ring, BAUD, 0);
    return true;
}

static bool start(void)
{
    dg_world_init(&world);
    world.angle = angle;
    ram_nvm_init(&nvm, dg_store_size(&dg_ib_layout));
    return dg_ib_format(dg_ib_model_of(dg_device_find("ocd-ib-k3")), ram_nvm_port(&nvm)) == DG_OK &&
           make(&small, SMALL) && make(&large, LARGE);
}

/* Whole cycles so far; 0 when one has brought no position: IN of a K3 is at most 25 bits of it. */
static uint64_t answers(void)
{
    bool right = true;

    for (size_t i = 0; i < 2u * LARGE; i += 2u) {
        right = right && large.in[i] < 0x0200u && small.in[0] < 0x0200u;
    }
    return right ? whole : 0;
}

int main(int argc, char **argv)
{
    static const struct bench benches[] = {
        {"interbus.cycle-of-1", cycle_small, NULL, 1, 1},
        {"interbus.slave-of-64", cycle_large, NULL, 1, LARGE},
    };
    static const struct bench_bytes bytes[] = {{"ram.dg_ib", sizeof(struct dg_ib)}};
    static const struct bench_set set = {.benches = benches,
                                         .count = sizeof benches / sizeof benches[0],
                                         .bytes = bytes,
                                         .bytes_count = 1,
                                         .start = start,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}
