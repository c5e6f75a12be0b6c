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
#include "fuzz_input.h"
#include "ib_rig.h"

#define DEVICES 3u
#define K3 2u
#define WORDS 5u

struct bench {
    struct ib_rig rigs[DEVICES]; /* worlds and memories; the devices are in the ring */
    struct dg_ib devices[DEVICES];
    struct dg_ib_ring ring;
    uint16_t out[WORDS];
    uint16_t in[WORDS];
    uint16_t ids[DEVICES];
    dg_ns now;
};

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
    const struct dg_ib *device = &bench->devices[K3];

    for (size_t i = 0; i < DEVICES; i++) {
        fuzz_must(dg_ib_position(&bench->devices[i], bench->now) < dg_ib_range(&bench->devices[i]));
        fuzz_must((dg_ib_leds(&bench->devices[i], bench->now) & ~0x1Fu) == 0);
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
    const uint16_t before = bench->in[0];

    bench->now = dg_after(bench->now, DG_MS(1));
    const enum dg_ib_ring_result result =
        dg_ib_ring_cycle(&bench->ring, bench->now, bench->out, bench->in);
    if (result == DG_IB_RING_OK) {
        fuzz_must(bench->in[0] < 4096 && bench->in[1] < 256);
        check_k3(&bench->devices[K3], (uint32_t)bench->in[3] << 16 | bench->in[4]);
    } else {
        fuzz_must(bench->in[0] == before);
    }
    if (result == DG_IB_RING_IDENTIFY || result == DG_IB_RING_INTERRUPTED) {
        fuzz_must(dg_ib_ring_id(&bench->ring, bench->now, bench->ids) <= DEVICES);
    }
    check(bench);
}

/* Operations; each takes what it needs from the input. */

static void send(struct bench *bench, uint32_t word, unsigned cycles)
{
    bench->out[3] = (uint16_t)(word >> 16);
    bench->out[4] = (uint16_t)word;
    for (unsigned i = 0; i < cycles; i++) {
        cycle(bench);
    }
}

static void op_word(struct bench *bench, struct fuzz_input *input)
{
    const uint32_t word = fuzz_take32(input);

    send(bench, word, fuzz_take(input) % 6u);
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
    const uint32_t *const row = known[fuzz_take(input) % (sizeof known / sizeof known[0])];

    send(bench, row[0] | (fuzz_take32(input) & row[1]), 5);
}

static void op_torn(struct bench *bench, struct fuzz_input *input)
{
    bench->out[3] = (uint16_t)fuzz_take32(input);
    cycle(bench);
}

static void op_time(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t shift = fuzz_take(input) & 63u;

    bench->now = dg_after(bench->now, (uint64_t)fuzz_take(input) << shift);
    cycle(bench);
}

static void op_world(struct bench *bench, struct fuzz_input *input)
{
    struct ib_rig *rig = &bench->rigs[fuzz_take(input) % DEVICES];
    const uint8_t bits = fuzz_take(input);

    rig->angle = (dg_angle)((uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input));
    rig->angle_per_ms = (int64_t)(int32_t)fuzz_take32(input) * 256;
    rig->world.temperature_mdegc = (int32_t)fuzz_take32(input);
    rig->world.singleturn_ok = (bits & 1u) != 0;
    rig->world.multiturn_sync_ok = (bits & 2u) != 0;
    rig->world.eeprom_acknowledges = (bits & 4u) == 0;
    rig->nvm.no_acknowledge = (bits & 8u) != 0;
    cycle(bench);
}

static void op_ring(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    bench->ring.broken_at = (how & 8u) != 0 ? how % 8u : DG_IB_RING_WHOLE;
    bench->ring.corrupt_at = (how & 16u) != 0 ? how % 8u : DG_IB_RING_WHOLE;
    cycle(bench);
}

static void op_rot(struct bench *bench, struct fuzz_input *input)
{
    struct ram_nvm *nvm = &bench->rigs[K3].nvm;
    const uint32_t where = fuzz_take32(input);

    nvm->bytes[(where >> 3) % nvm->size] ^= (uint8_t)(1u << (where & 7u));
}

static void op_power(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    struct dg_ib *device = &bench->devices[how % DEVICES];
    struct ram_nvm *nvm = &bench->rigs[how % DEVICES].nvm;

    if ((how & 64u) != 0) {
        ram_nvm_cut(nvm, how & 31u, (enum ram_nvm_tear)(fuzz_take(input) % RAM_NVM_TEAR_COUNT),
                    fuzz_take(input));
        return;
    }
    ram_nvm_restore(nvm);
    if (dg_ib_power_on(device, bench->now) != DG_OK) {
        fuzz_must(!device->powered);
        fuzz_must(dg_ib_format(device->setup.model, device->setup.nvm) == DG_OK);
        fuzz_must(dg_ib_power_on(device, bench->now) == DG_OK);
    }
    cycle(bench);
}

static void set_up(struct bench *bench, struct fuzz_input *input)
{
    static const char *const names[DEVICES] = {"ocd-ib-k1", "ocd-ib-k2", "ocd-ib-k3"};

    memset(bench, 0, sizeof *bench);
    for (size_t i = 0; i < DEVICES; i++) {
        struct dg_ib_model model = *dg_ib_model_of(dg_device_find(names[i]));
        if (i == K3) {
            const uint8_t how = fuzz_take(input);
            model.steps_minus_one = (how & 1u) != 0;
            model.turns = (how & 2u) != 0 ? 1 : 4096;
            model.param_cycles = (uint8_t)(1u + (how >> 6));
        }
        fuzz_must(ib_rig_init(&bench->rigs[i], &model) == DG_OK);
        bench->devices[i] = bench->rigs[i].device;
        fuzz_must(dg_ib_power_on(&bench->devices[i], 0) == DG_OK);
    }
    fuzz_must(dg_ib_ring_init(&bench->ring, bench->devices, DEVICES) == DG_OK);
    bench->now = DG_MS(100);
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
        operations[fuzz_take(&input) % (sizeof operations / sizeof operations[0])](&bench, &input);
    }
    return 0;
}
