/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: a ring of a K1, a K2 and a K3 in a hostile world. The input is a stream of
 * operations: OUT words, time, a bent world, a rotting, failing or powerless EEPROM, faults of the
 * ring. After each cycle: nothing overflows, and IN is a word that the manual knows.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "drehgeber/interbus.h"
#include "fuzz_input.h"
#include "ram_nvm.h"
#include "ring_rig.h"

#define DEVICES 3u
#define K3 2u

/* A shaft that turns steadily. */
struct shaft {
    dg_angle angle;
    int64_t angle_per_ms;
};

struct bench {
    struct ring_rig ring;
    struct shaft shafts[DEVICES];
    struct ram_nvm nvm; /* of the K3 */
};

static struct dg_ib *device_at(const struct bench *bench, size_t place)
{
    return ring_rig_device(&bench->ring, place);
}

/* Whole milliseconds and the rest apart, modulo 2^64: nothing overflows. */
static dg_angle angle_of(void *ctx, dg_ns now)
{
    const struct shaft *self = ctx;
    const uint64_t whole = (uint64_t)self->angle_per_ms * (now / DG_MS(1));
    const int64_t rest = self->angle_per_ms * (int64_t)(now % DG_MS(1)) / (int64_t)DG_MS(1);

    return (dg_angle)((uint64_t)self->angle + whole + (uint64_t)rest);
}

/* 9.3, 9.4, 9.6: what a K3 may show. */
static void check_k3(const struct dg_ib *device, uint32_t in)
{
    const bool cams = device->mode > DG_IB_CAM;

    if (in >> 30 == 3 || in >> 25 == DG_IB_READ_OUT >> 25) {
        return; /* answers and read-outs */
    }
    if (in >> 25 == DG_IB_UNKNOWN_ITEM >> 25) {
        fuzz_must(device->item != 0 || device->answer != 0);
        return;
    }
    if (in == DG_IB_ILLEGAL_DATA || in == DG_IB_UNKNOWN_CODE || in == DG_IB_LOST ||
        in == DG_IB_CAM_POSITION) {
        return;
    }
    fuzz_must((in & ~DG_IB_NOT_VALID) >> 25 == 0);
    fuzz_must(in >> 31 == device->invalid);
    fuzz_must(cams || device->mode == DG_IB_SPEED || (in & DG_IB_DATA_MASK) < dg_ib_range(device));
}

static void check(const struct bench *bench)
{
    const struct dg_ib *device = device_at(bench, K3);
    const dg_ns now = bench->ring.now;

    for (size_t i = 0; i < DEVICES; i++) {
        const struct dg_ib *each = device_at(bench, i);
        fuzz_must(dg_ib_position(each, now) < dg_ib_range(each));
        fuzz_must((dg_ib_leds(each, now) & ~0x1Fu) == 0);
    }
    fuzz_must(device->mode >= DG_IB_POSITION && device->mode <= DG_IB_CAM + DG_IB_PROGRAMS);
    fuzz_must(device->shift_iw <= 25);
    fuzz_must(device->steps > 0 && device->revolutions > 0);
    fuzz_must((uint64_t)device->steps <=
              (uint64_t)device->revolutions * device->setup.model->steps);
    fuzz_must(dg_ib_range(device) <= DG_IB_DATA_MASK + 1u);
}

static void cycle(struct bench *bench)
{
    struct ring_rig *ring = &bench->ring;
    const uint16_t before = ring->in[0];

    ring->now = dg_after(ring->now, DG_MS(1));
    const enum dg_ring_result result = ring_rig_cycle(ring);
    if (result == DG_RING_OK && !dg_ring_state(ring->bus)->dropped) {
        fuzz_must(ring->in[0] < 4096 && ring->in[1] < 256);
        check_k3(device_at(bench, K3), (uint32_t)ring->in[3] << 16 | ring->in[4]);
    } else {
        fuzz_must(ring->in[0] == before);
    }
    fuzz_must(dg_ring_state(ring->bus)->reached <= DEVICES);
    check(bench);
}

/* Operations; each takes what it needs from the input. */

static void send_word(struct bench *bench, uint32_t word, unsigned cycles)
{
    bench->ring.out[3] = (uint16_t)(word >> 16);
    bench->ring.out[4] = (uint16_t)word;
    for (unsigned i = 0; i < cycles; i++) {
        cycle(bench);
    }
}

static void op_word(struct bench *bench, struct fuzz_input *input)
{
    const uint32_t word = fuzz_take32(input);

    send_word(bench, word, fuzz_take(input) % 6u);
}

/* A command that exists, data from the input. */
static void op_command(struct bench *bench, struct fuzz_input *input)
{
    static const uint32_t known[][2] = {
        {0x00000000, 0},          {0x80000000, 0},          {0x40000000, 0},
        {0x60000000, 0},          {0x02000000, 0x01FFFFFF}, {0x04000000, 0x1FFF},
        {0x06000000, 7},          {0x08000000, 0x01FFFFFF}, {0x0A000000, 0x01FFFFFF},
        {0x0E000000, 0},          {0x20400000, 0xFF},       {0x20800000, 0x0F},
        {0x20210000, 0xFF},       {0x20100000, 0x1F},       {0x20200000, 0x3F},
        {0x40000000, 0x0FFFFFFF}, {0x60000000, 0x0FFFFFFF},
    };
    const uint32_t *const row = known[fuzz_take(input) % (DG_COUNT(known))];

    send_word(bench, row[0] | (fuzz_take32(input) & row[1]), 5);
}

static void op_torn(struct bench *bench, struct fuzz_input *input)
{
    bench->ring.out[3] = (uint16_t)fuzz_take32(input);
    cycle(bench);
}

static void op_time(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t shift = fuzz_take(input) & 63u;

    bench->ring.now = dg_after(bench->ring.now, (uint64_t)fuzz_take(input) << shift);
    cycle(bench);
}

static void op_world(struct bench *bench, struct fuzz_input *input)
{
    const size_t place = fuzz_take(input) % DEVICES;
    const uint8_t bits = fuzz_take(input);
    struct shaft *shaft = &bench->shafts[place];
    struct dg_world *world = ring_rig_world(&bench->ring, place);

    shaft->angle = (dg_angle)((uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input));
    shaft->angle_per_ms = (int64_t)(int32_t)fuzz_take32(input) * 256;
    world->temperature_mdegc = (int32_t)fuzz_take32(input);
    world->singleturn_ok = (bits & 1u) != 0;
    world->multiturn_sync_ok = (bits & 2u) != 0;
    world->eeprom_acknowledges = (bits & 4u) == 0;
    if (place == K3) {
        bench->nvm.no_acknowledge = (bits & 8u) != 0;
    }
    cycle(bench);
}

static void op_ring(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    dg_ring_cut(bench->ring.bus, (how & 8u) != 0 ? how % 8u : DG_RING_WHOLE);
    dg_ring_spoil(bench->ring.bus, (how & 16u) != 0 ? how % 8u : DG_RING_WHOLE);
    if ((how & 32u) != 0) {
        ring_rig_bend(&bench->ring, how % DEVICES, (how & 64u) != 0 ? DG_WIRE_DROP : DG_WIRE_DAMAGE,
                      1u + how % 4u);
    }
    cycle(bench);
}

static void op_rot(struct bench *bench, struct fuzz_input *input)
{
    struct ram_nvm *nvm = &bench->nvm;
    const uint32_t where = fuzz_take32(input);

    nvm->bytes[(where >> 3) % nvm->size] ^= (uint8_t)(1u << (where & 7u));
}

static void op_power(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    struct dg_ib *device = device_at(bench, how % DEVICES);
    struct ram_nvm *nvm = &bench->nvm;

    if ((how & 64u) != 0) {
        ram_nvm_cut(nvm, how & 31u, (enum ram_nvm_tear)(fuzz_take(input) % RAM_NVM_TEAR_COUNT),
                    fuzz_take(input));
        return;
    }
    ram_nvm_restore(nvm);
    if (dg_ib_power_on(device, bench->ring.now) != DG_OK) {
        fuzz_must(!device->powered);
        fuzz_must(dg_ib_format(device->setup.model, device->setup.nvm) == DG_OK);
        fuzz_must(dg_ib_power_on(device, bench->ring.now) == DG_OK);
    }
    (void)dg_bus_changed(bench->ring.bus, how % DEVICES, bench->ring.now);
    cycle(bench);
}

static void make_k3(struct bench *bench, struct dg_host *encoder, uint8_t how)
{
    struct dg_ib_model *model = dg_host_line_of(encoder)->settings;

    model->steps_minus_one = (how & 1u) != 0;
    model->turns = (how & 2u) != 0 ? 1 : 4096;
    model->param_cycles = (uint8_t)(1u + (how >> 6));
    ram_nvm_init(&bench->nvm, dg_store_size(&dg_ib_layout));
    const struct dg_nvm nvm = ram_nvm_port(&bench->nvm);
    fuzz_must(dg_host_memory_port(encoder, &nvm) == DG_HOST_OK);
}

static void set_up(struct bench *bench, struct fuzz_input *input)
{
    static const char *const names[DEVICES] = {"ocd-ib-k1", "ocd-ib-k2", "ocd-ib-k3"};

    memset(bench->shafts, 0, sizeof bench->shafts);
    ring_rig_init(&bench->ring);
    bench->ring.wire.identifies = true;
    for (size_t i = 0; i < DEVICES; i++) {
        struct dg_host *encoder = ring_rig_add(&bench->ring, names[i]);
        struct dg_world *world = ring_rig_world(&bench->ring, i);
        world->angle = angle_of;
        world->angle_ctx = &bench->shafts[i];
        if (i == K3) {
            make_k3(bench, encoder, fuzz_take(input));
        }
    }
    ring_rig_open(&bench->ring);
    bench->ring.now = DG_MS(100);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct bench *, struct fuzz_input *) = {
        op_word, op_command, op_command, op_command, op_torn,
        op_time, op_world,   op_ring,    op_rot,     op_power,
    };
    static struct bench bench;
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    set_up(&bench, &input);
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&bench, &input);
    }
    return 0;
}
