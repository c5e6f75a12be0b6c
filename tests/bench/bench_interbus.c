/* SPDX-License-Identifier: MIT */
/*
 * Rings of K3 encoders: a data cycle of one, and of many, for each of them.
 */
#include <stdalign.h>

#include "bench.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/devices.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/interbus.h"
#include "ram_nvm.h"

#define SMALL 1u
#define LARGE 64u
#define BAUD 2000000u
#define ROOM 16384u

struct subject {
    alignas(DG_HOST_ALIGN) uint8_t handles[LARGE][ROOM];
    alignas(DG_HOST_ALIGN) uint8_t of_ring[ROOM];
    struct dg_bus *ring;
    const struct dg_ring_state *state;
    struct dg_tap_event event; /* the cycle, again and again */
    uint16_t out[DG_RING_WORDS_MAX * LARGE];
    uint16_t in[DG_RING_WORDS_MAX * LARGE];
    dg_ns cycle;
};
static struct subject small, large;
static struct ram_nvm nvm; /* serves all: none of them stores anything here */
static uint64_t whole;

/* A shaft at constant speed that costs nothing: the encoders are measured, not the motion. */
static dg_angle angle(void *ctx, dg_ns at)
{
    (void)ctx;
    return (dg_angle)at;
}

static void run(struct subject *self)
{
    self->event.at += self->cycle;
    (void)dg_bus_rx(self->ring, &self->event);
    whole += self->state->result == DG_RING_OK ? 1u : 0u;
}

static void cycle_small(const void *what)
{
    (void)what;
    run(&small);
}

static void cycle_large(const void *what)
{
    (void)what;
    run(&large);
}

static bool add(struct subject *self, size_t place)
{
    const struct dg_nvm port = ram_nvm_port(&nvm);
    struct dg_host *encoder =
        dg_host_init_on_bus(self->handles[place], ROOM, &dg_ocd_ib_k3, &dg_ib_side);

    dg_host_world(encoder)->angle = angle;
    return dg_host_memory_port(encoder, &port) == DG_HOST_OK &&
           dg_host_power(encoder, 0, true) == DG_HOST_OK &&
           dg_bus_attach(self->ring, encoder, NULL) == (int)place;
}

static bool make(struct subject *self, uint16_t count)
{
    static const struct dg_bus_ops ops = {.tx = NULL};
    const struct dg_bus_words_setup wire = {sizeof wire, self->in, DG_COUNT(self->in), false};
    const struct dg_bus_setup setup = {sizeof setup, &dg_bus_words, count, &wire, &ops, NULL};
    bool made = true;

    self->ring = dg_bus_init(self->of_ring, ROOM, &setup);
    for (uint16_t i = 0; self->ring != NULL && i < count; i++) {
        made = made && add(self, i);
    }
    if (self->ring == NULL || !made) {
        return false;
    }
    self->state = dg_ring_state(self->ring);
    self->event = (struct dg_tap_event){
        .at = DG_S(1), .kind = DG_TAP_WORDS, .words = {.out = self->out, .identify = true}};
    (void)dg_bus_rx(self->ring, &self->event);
    self->event.words.identify = false;
    self->event.words.count = self->state->words;
    self->cycle = dg_ib_cycle_time(self->state->words, count, BAUD, 0);
    return self->state->reached == count;
}

static bool start_rings(void)
{
    ram_nvm_init(&nvm, dg_store_size(&dg_ib_layout));
    return make(&small, SMALL) && make(&large, LARGE);
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
                                         .count = DG_COUNT(benches),
                                         .bytes = bytes,
                                         .bytes_count = 1,
                                         .start = start_rings,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}
