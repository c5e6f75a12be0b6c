/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: S36 with BiSS on a hostile line. The input is a stream of operations: edges and
 * silences of any length, frames with any CDM bit, register accesses, a bent world, a rotting or
 * powerless EEPROM, power cycles. After each one: the state is one there is, deadlines lie ahead,
 * and after 40 us of silence a frame is whole.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "biss_rig.h"
#include "drehgeber/bits.h"
#include "drehgeber/devices.h"

/* What is left of the input. */
struct input {
    const uint8_t *at;
    const uint8_t *end;
};

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n);

static struct biss_rig rig;

static void must(bool holds)
{
    if (!holds) {
        abort();
    }
}

static uint8_t take(struct input *input)
{
    return input->at < input->end ? *input->at++ : 0;
}

static uint32_t take32(struct input *input)
{
    uint8_t bytes[4];

    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = take(input);
    }
    return dg_load_le32(bytes);
}

static void check(const struct dg_biss *slave)
{
    const struct dg_biss_control *control = &slave->control;

    must(slave->line.state <= DG_BISS_RETURN);
    must(slave->line.length <= 62);
    must(slave->line.start <= dg_after(rig.now, DG_BISS_BUSY_S_MAX_NS));
    must(control->state < DG_BISS_CONTROL_STATE_COUNT);
    must(control->zeros <= DG_BISS_ZEROS);
    must(control->count <= 15);
    must(control->id < DG_BISS_CHAIN_MAX || control->id == DG_BISS_NO_ID);
    must(control->ready <= dg_after(rig.now, 2u * DG_BISS_BUSY_R_MAX_NS));
    must(slave->life <= 63);
    must(slave->timeout <= 7);
    must((slave->config[0] & 0x38u) == 0 || !slave->mounted);
}

static void pass(uint64_t ns)
{
    rig.now = dg_after(rig.now, ns);
}

/* Silence, and MA high: whatever was, the next frame is in order. */
static void recover(void)
{
    pass(40000);
    const dg_ns deadline = dg_biss_step(&rig.slave[0], rig.now);
    must(deadline == DG_NEVER);
    (void)dg_biss_ma(&rig.slave[0], rig.now, true);
    /* It is high, too, unless no frame has been since the start. */
    must(dg_biss_slo(&rig.slave[0], false) || !rig.slave[0].started);
}

static void op_edges(struct input *input)
{
    for (unsigned n = take(input); n > 0; n--) {
        const uint8_t how = take(input);
        pass((uint64_t)(how & 0x1Fu) << (how >> 5 << 1));
        (void)dg_biss_ma(&rig.slave[0], rig.now, (how & 1u) != 0);
        const dg_ns deadline = dg_biss_step(&rig.slave[0], rig.now);
        must(deadline > rig.now);
    }
}

static void op_clocks(struct input *input)
{
    const uint8_t n = take(input);

    recover();
    biss_rig_cut(&rig, n);
}

/* Only a powered slave that sends data, and has a timeout longer than the rig's clocks. */
static void op_frame(struct input *input)
{
    struct dg_biss *slave = &rig.slave[0];
    const bool sends = slave->line.state != DG_BISS_OFF && !slave->channel_off;
    const bool cdm = (take(input) & 1u) != 0;

    recover();
    if (slave->line.state == DG_BISS_OFF) {
        return;
    }
    (void)biss_rig_frame(&rig, cdm);
    must(!sends || (rig.bits & 0x3Fu) == biss_rig_crc6(rig.bits >> 6, rig.data_bits - 6u));
}

/* Frames at once, eight CDM bits. */
static void op_words(struct input *input)
{
    const uint8_t cdm = take(input);

    recover();
    for (unsigned i = 0; i < 8; i++) {
        uint64_t bits = 0;
        pass(50000);
        const uint8_t n = dg_biss_frame(&rig.slave[0], rig.now, &bits);
        must(n == 64 || bits >> n == 0);
        dg_biss_frame_end(&rig.slave[0], rig.now, (cdm >> i & 1u) != 0);
    }
}

static void op_read(struct input *input)
{
    uint8_t bytes[DG_BISS_BANK_SIZE];

    recover();
    rig.words = rig.slave[0].line.state != DG_BISS_OFF;
    if (rig.words) {
        const uint8_t address = take(input);
        (void)biss_rig_read(&rig, address >> 7, address & 0x7Fu, bytes, 1u + take(input) % 64u);
    }
    rig.words = false;
}

static void op_write(struct input *input)
{
    static const uint8_t favourites[] = {0x40, 0x60, 0x7C, 0x1B, 0x22, 0x00, 0x3F};
    uint8_t bytes[4];

    recover();
    rig.words = rig.slave[0].line.state != DG_BISS_OFF;
    if (rig.words) {
        const uint8_t how = take(input);
        dg_store_le32(bytes, take32(input));
        const uint8_t address =
            how < 0x80 ? how : favourites[how % (sizeof favourites / sizeof favourites[0])];
        (void)biss_rig_write(&rig, 0, address, bytes, 1u + (bytes[3] & 3u));
    }
    rig.words = false;
}

static void op_command(struct input *input)
{
    recover();
    rig.words = rig.slave[0].line.state != DG_BISS_OFF;
    if (rig.words) {
        const uint8_t ids = take(input);
        (void)biss_rig_command(&rig, ids, take(input) & 3u);
    }
    rig.words = false;
}

static void op_time(struct input *input)
{
    const uint8_t how = take(input);

    pass((uint64_t)take(input) << (how & 63u) % 40u);
    if ((how & 64u) != 0) {
        must(dg_biss_step(&rig.slave[0], rig.now) > rig.now || rig.now == DG_NEVER);
    }
}

static void op_world(struct input *input)
{
    struct dg_world *world = &rig.world;
    const uint8_t bits = take(input);

    rig.angle = (dg_angle)((uint64_t)take32(input) << 32 | take32(input));
    rig.angle_per_us = (int32_t)take32(input);
    world->temperature_mdegc = (int32_t)take32(input);
    world->led_current_ua = take32(input);
    world->sin_offset_permille = (int16_t)(take32(input) % 2001u - 1000u);
    world->singleturn_ok = (bits & 1u) != 0;
    world->multiturn_sync_ok = (bits & 2u) != 0;
    world->watchdog_fired = (bits & 4u) != 0;
    world->eeprom_acknowledges = (bits & 8u) != 0;
}

static void op_rot(struct input *input)
{
    const uint32_t where = take32(input);

    rig.nvm[0].bytes[(where >> 3) % rig.nvm[0].size] ^= (uint8_t)(1u << (where & 7u));
}

static void op_cut(struct input *input)
{
    const uint8_t how = take(input);

    ram_nvm_cut(&rig.nvm[0], how & 31u, (enum ram_nvm_tear)((how >> 5) % RAM_NVM_TEAR_COUNT),
                take(input));
}

static void op_power(struct input *input)
{
    const uint8_t how = take(input);

    if ((how & 1u) != 0) {
        ram_nvm_restore(&rig.nvm[0]);
    }
    const int result = dg_biss_power_on(&rig.slave[0], rig.now);
    must(result == DG_OK || result == DG_ERR_BLANK || result == DG_ERR_FOREIGN);
    must((result != DG_OK) == (rig.slave[0].line.state == DG_BISS_OFF));
    if ((how & 6u) == 6u) {
        dg_biss_power_off(&rig.slave[0]);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct input *) = {
        op_edges,   op_clocks, op_frame, op_words, op_read, op_write,
        op_command, op_time,   op_world, op_rot,   op_cut,  op_power,
    };
    struct input input = {.at = bytes, .end = bytes + n};
    struct dg_biss_model model =
        *dg_biss_model_of(dg_device_find((take(&input) & 1u) != 0 ? "s3674-biss" : "s3684-biss"));

    const uint8_t kind = take(&input);
    model.stop_bit_early = (kind & 1u) != 0;
    model.sl_low_at_start = (kind & 2u) != 0;
    model.busy = DG_US(take(&input) % 41u);
    model.busy_jitter = (DG_BISS_BUSY_S_MAX_NS - model.busy) * (kind >> 2) / 63u;
    model.eeprom_read = DG_US(take(&input));
    model.eeprom_write = DG_US(10u * take(&input));
    model.multiturn_bits = take(&input) % 25u;
    model.singleturn_bits = (uint8_t)(12u + take(&input) % 13u);
    model.autostore = (take(&input) & 1u) != 0;
    must(biss_rig_init(&rig, &model, 1) == DG_OK && biss_rig_power_on(&rig) == DG_OK);
    while (input.at < input.end) {
        operations[take(&input) % (sizeof operations / sizeof operations[0])](&input);
        check(&rig.slave[0]);
    }
    return 0;
}
