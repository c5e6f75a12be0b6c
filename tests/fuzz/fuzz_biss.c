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
#include <string.h>

#include "biss_rig.h"
#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "fuzz_input.h"

static struct biss_rig rig;

static void check(const struct dg_biss *slave)
{
    const struct dg_biss_control *control = &slave->control;

    fuzz_must(slave->line.state <= DG_BISS_RETURN);
    fuzz_must(slave->line.length <= 62);
    fuzz_must(slave->line.start <= dg_after(rig.now, DG_BISS_BUSY_S_MAX_NS));
    fuzz_must(control->state < DG_BISS_CONTROL_STATE_COUNT);
    fuzz_must(control->zeros <= DG_BISS_ZEROS);
    fuzz_must(control->count <= 15);
    fuzz_must(control->id < DG_BISS_CHAIN_MAX || control->id == DG_BISS_NO_ID);
    fuzz_must(control->ready <= dg_after(rig.now, 2u * DG_BISS_BUSY_R_MAX_NS));
    fuzz_must(slave->life <= 63);
    fuzz_must(slave->timeout <= 7);
    fuzz_must((slave->config[0] & 0x38u) == 0 || !slave->mounted);
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
    fuzz_must(deadline == DG_NEVER);
    (void)dg_biss_ma(&rig.slave[0], rig.now, true);
    /* It is high, too, unless no frame has been since the start. */
    fuzz_must(dg_biss_slo(&rig.slave[0], false) || !rig.slave[0].started);
}

static void op_edges(struct fuzz_input *input)
{
    for (unsigned n = fuzz_take(input); n > 0; n--) {
        const uint8_t how = fuzz_take(input);
        pass((uint64_t)(how & 0x1Fu) << (how >> 5 << 1));
        (void)dg_biss_ma(&rig.slave[0], rig.now, (how & 1u) != 0);
        const dg_ns deadline = dg_biss_step(&rig.slave[0], rig.now);
        fuzz_must(deadline > rig.now);
    }
}

static void op_clocks(struct fuzz_input *input)
{
    const uint8_t n = fuzz_take(input);

    recover();
    biss_rig_cut(&rig, n);
}

/* Only a powered slave that sends data, and has a timeout longer than the rig's clocks. */
static void op_frame(struct fuzz_input *input)
{
    struct dg_biss *slave = &rig.slave[0];
    const bool sends = slave->line.state != DG_BISS_OFF && !slave->channel_off;
    const bool cdm = (fuzz_take(input) & 1u) != 0;

    recover();
    if (slave->line.state == DG_BISS_OFF) {
        return;
    }
    (void)biss_rig_frame(&rig, cdm);
    fuzz_must(!sends || (rig.bits & 0x3Fu) == biss_rig_crc6(rig.bits >> 6, rig.data_bits - 6u));
}

/* Frames at once, eight CDM bits. */
static void op_words(struct fuzz_input *input)
{
    const uint8_t cdm = fuzz_take(input);

    recover();
    for (unsigned i = 0; i < 8; i++) {
        uint64_t bits = 0;
        pass(50000);
        const uint8_t n = dg_biss_frame(&rig.slave[0], rig.now, &bits);
        fuzz_must(n == 64 || bits >> n == 0);
        dg_biss_frame_end(&rig.slave[0], rig.now, (cdm >> i & 1u) != 0);
    }
}

static void op_read(struct fuzz_input *input)
{
    uint8_t bytes[DG_BISS_BANK_SIZE];

    recover();
    rig.words = rig.slave[0].line.state != DG_BISS_OFF;
    if (rig.words) {
        const uint8_t address = fuzz_take(input);
        (void)biss_rig_read(&rig, address >> 7, address & 0x7Fu, bytes,
                            1u + fuzz_take(input) % 64u);
    }
    rig.words = false;
}

static void op_write(struct fuzz_input *input)
{
    static const uint8_t favourites[] = {0x40, 0x60, 0x7C, 0x1B, 0x22, 0x00, 0x3F};
    uint8_t bytes[4];

    recover();
    rig.words = rig.slave[0].line.state != DG_BISS_OFF;
    if (rig.words) {
        const uint8_t how = fuzz_take(input);
        dg_store_le32(bytes, fuzz_take32(input));
        const uint8_t address = how < 0x80 ? how : favourites[how % (DG_COUNT(favourites))];
        (void)biss_rig_write(&rig, 0, address, bytes, 1u + (bytes[3] & 3u));
    }
    rig.words = false;
}

static void op_command(struct fuzz_input *input)
{
    recover();
    rig.words = rig.slave[0].line.state != DG_BISS_OFF;
    if (rig.words) {
        const uint8_t ids = fuzz_take(input);
        (void)biss_rig_command(&rig, ids, fuzz_take(input) & 3u);
    }
    rig.words = false;
}

static void op_time(struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    pass((uint64_t)fuzz_take(input) << (how & 63u) % 40u);
    if ((how & 64u) != 0) {
        fuzz_must(dg_biss_step(&rig.slave[0], rig.now) > rig.now || rig.now == DG_NEVER);
    }
}

static void op_world(struct fuzz_input *input)
{
    struct dg_world *world = &rig.world;
    const uint8_t bits = fuzz_take(input);

    rig.angle = (dg_angle)((uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input));
    rig.angle_per_us = (int32_t)fuzz_take32(input);
    world->temperature_mdegc = (int32_t)fuzz_take32(input);
    world->led_current_ua = fuzz_take32(input);
    world->sin_offset_permille = (int16_t)(fuzz_take32(input) % 2001u - 1000u);
    world->singleturn_ok = (bits & 1u) != 0;
    world->multiturn_sync_ok = (bits & 2u) != 0;
    world->watchdog_fired = (bits & 4u) != 0;
    world->eeprom_acknowledges = (bits & 8u) != 0;
}

static void op_rot(struct fuzz_input *input)
{
    const uint32_t where = fuzz_take32(input);

    rig.nvm[0].bytes[(where >> 3) % rig.nvm[0].size] ^= (uint8_t)(1u << (where & 7u));
}

static void op_cut(struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    ram_nvm_cut(&rig.nvm[0], how & 31u, (enum ram_nvm_tear)((how >> 5) % RAM_NVM_TEAR_COUNT),
                fuzz_take(input));
}

static void op_power(struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    if ((how & 1u) != 0) {
        ram_nvm_restore(&rig.nvm[0]);
    }
    const int result = dg_biss_power_on(&rig.slave[0], rig.now);
    fuzz_must(result == DG_OK || result == DG_ERR_BLANK || result == DG_ERR_FOREIGN);
    fuzz_must((result != DG_OK) == (rig.slave[0].line.state == DG_BISS_OFF));
    if ((how & 6u) == 6u) {
        dg_biss_power_off(&rig.slave[0]);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct fuzz_input *) = {
        op_edges,   op_clocks, op_frame, op_words, op_read, op_write,
        op_command, op_time,   op_world, op_rot,   op_cut,  op_power,
    };
    struct fuzz_input input = {.at = bytes, .end = bytes + n};
    struct dg_biss_model model = *dg_biss_model_of(
        dg_device_find((fuzz_take(&input) & 1u) != 0 ? "s3674-biss" : "s3684-biss"));

    const uint8_t kind = fuzz_take(&input);
    model.stop_bit_early = (kind & 1u) != 0;
    model.sl_low_at_start = (kind & 2u) != 0;
    model.busy = DG_US(fuzz_take(&input) % 41u);
    model.busy_jitter = (DG_BISS_BUSY_S_MAX_NS - model.busy) * (kind >> 2) / 63u;
    model.eeprom_read = DG_US(fuzz_take(&input));
    model.eeprom_write = DG_US(10u * fuzz_take(&input));
    model.multiturn_bits = fuzz_take(&input) % 25u;
    model.singleturn_bits = (uint8_t)(12u + fuzz_take(&input) % 13u);
    model.autostore = (fuzz_take(&input) & 1u) != 0;
    fuzz_must(biss_rig_init(&rig, &model, 1) == DG_OK && biss_rig_power_on(&rig) == DG_OK);
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&input);
        check(&rig.slave[0]);
    }
    return 0;
}
