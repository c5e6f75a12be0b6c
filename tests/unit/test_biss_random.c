/* SPDX-License-Identifier: MIT */
/*
 * Random register traffic against a model of the register space: reads and writes of any length
 * anywhere, control frames given up at any bit, frames cut short, busy EEPROM, jitter on the clock.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"
#include "effort.h"

#define OPERATIONS 400u

/* What a master may expect. */
struct model {
    uint8_t bank;
    uint8_t timeout;
    uint8_t config[9];
    uint8_t user[25][64];
};

static struct biss_rig rig;
static struct model model;
static uint32_t noise;

static uint32_t dice(uint32_t sides)
{
    noise = noise * 1664525u + 1013904223u;
    return (noise >> 8) % sides;
}

static void reset(uint32_t seed)
{
    struct dg_biss_model figures = *dg_biss_model_of(dg_device_find("s3684-biss"));

    noise = seed;
    memset(&model, 0, sizeof model);
    model.config[7] = 0xFB;
    memset(model.user, 0xFF, sizeof model.user);
    figures.eeprom_read = DG_US(dice(60));
    figures.eeprom_write = DG_US(dice(2000));
    figures.busy = DG_US(dice(21));
    figures.busy_jitter = DG_US(dice(20));
    figures.stop_bit_early = seed % 2u == 0;
    figures.singleturn_bits = seed % 3u == 0 ? 24 : 21;
    assert_int_equal(biss_rig_init(&rig, &figures, 1), DG_OK);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    rig.half_ns = 50u + dice(800);
    rig.jitter = dice(2) * 250u;
}

/* Where a byte is that can be written, or NULL. */
static uint8_t *cell(uint8_t address)
{
    if (address == 0x40) {
        return &model.bank;
    }
    if (address == 0x7C) {
        return &model.timeout;
    }
    if (address < 0x40 && model.bank >= 7 && model.bank <= 31) {
        return &model.user[model.bank - 7][address];
    }
    if (address >= 0x1B && address <= 0x23 && model.bank == 0) {
        return &model.config[address - 0x1B];
    }
    return NULL;
}

static bool readable(uint8_t address)
{
    const bool fixed = (address >= 0x40 && address <= 0x47) ||
                       (address >= 0x60 && address <= 0x6B) || (address >= 0x78 && address <= 0x7F);

    return fixed || (address < 0x40 && (model.bank == 3 || model.bank == 4)) ||
           cell(address) != NULL;
}

static uint8_t kept(uint8_t address, uint8_t value)
{
    if (address == 0x7C) {
        return value & 0x07;
    }
    return address == 0x1B && model.bank == 0 ? value & 0xC7 : value;
}

/* As many as can be accessed from `address` on, at most `n`. */
static int run_of(uint8_t address, int n, bool write)
{
    int count = 0;

    while (count < n) {
        const uint8_t at = (uint8_t)(address + count);
        if (write ? cell(at) == NULL : !readable(at)) {
            break;
        }
        count++;
        if (at == 0x3F || at == 0x7F) {
            break;
        }
    }
    return count == 0 ? BISS_RIG_REFUSED : count;
}

/* Half of the traffic goes to registers that can be written. */
static uint8_t any_address(void)
{
    static const uint8_t writable[] = {0x40, 0x7C, 0x1B, 0x1C, 0x21, 0x00, 0x3F, 0x20};

    return (uint8_t)(dice(2) == 0 ? writable[dice(8)] : dice(0x60) | dice(0x80));
}

static void op_read(void)
{
    uint8_t bytes[64] = {0};
    const uint8_t address = any_address() & 0x7F;
    const int n = (int)(dice(3) == 0 ? 1u + dice(64) : 1u);
    const int count = biss_rig_read(&rig, 0, address, bytes, (size_t)n);

    assert_int_equal(count, run_of(address, n, false));
    for (int i = 0; i < count; i++) {
        const uint8_t *expected = cell((uint8_t)(address + i));
        if (expected != NULL) {
            assert_int_equal(bytes[i], *expected);
        }
    }
}

static void op_write(void)
{
    uint8_t bytes[64];
    const uint8_t address = any_address() & 0x7F;
    const int n = (int)(dice(8) == 0 ? 1u + dice(8) : 1u);

    if (address == 0x60) {
        return; /* a command, not a value */
    }
    for (int i = 0; i < n; i++) {
        bytes[i] = (uint8_t)dice(256);
    }
    bytes[0] = address == 0x40 ? (uint8_t)dice(36) : bytes[0];
    const int expected = run_of(address, n, true);
    assert_int_equal(biss_rig_write(&rig, 0, address, bytes, (size_t)n), expected);
    for (int i = 0; i < expected; i++) {
        *cell((uint8_t)(address + i)) = kept((uint8_t)(address + i), bytes[i]);
    }
}

/* An addressing and some of the data, and no more than the control frame's first 12 bits of it. */
static void op_abort(void)
{
    const uint8_t address = any_address() & 0x7F;
    const bool write = dice(2) == 0;

    (void)biss_rig_address(&rig, 0, address, write);
    for (uint32_t i = dice(7); i > 0; i--) {
        (void)biss_rig_frame(&rig, true);
    }
    biss_rig_zeros(&rig);
    assert_int_equal(rig.slave[0].control.state, DG_BISS_CONTROL_READY);
}

/* Whatever it was taken for, zeros end it. */
static void op_cut(void)
{
    for (uint32_t i = dice(4); i > 0; i--) {
        biss_rig_cut(&rig, 2u * dice(60));
    }
}

static void op_command(void)
{
    (void)biss_rig_command(&rig, dice(2) == 0 ? 0xFF : 0, (uint8_t)(2u + dice(2)));
}

static void op_angle(void)
{
    rig.angle = (dg_angle)((uint64_t)noise << 31 ^ dice(1u << 20));
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.bits & 0x3Fu, biss_rig_crc6(rig.bits >> 6, rig.data_bits - 6u));
    assert_true(rig.bits >> 14 == dg_biss_position(&rig.slave[0], rig.now));
}

static void test_traffic(void **state)
{
    static void (*const operations[])(void) = {op_read,  op_read, op_write,   op_write,
                                               op_abort, op_cut,  op_command, op_angle};

    const uint32_t seeds = effort(2, 6);
    (void)state;
    for (uint32_t seed = 1; seed <= seeds; seed++) {
        reset(seed);
        for (uint32_t i = 0; i < OPERATIONS; i++) {
            operations[dice(DG_COUNT(operations))]();
            /* A short timeout is fine for fast clocks only. */
            if (model.timeout != 0 && rig.half_ns > 500) {
                rig.half_ns = 50;
            }
        }
        assert_true(rig.slave[0].counters.writes > 40);
    }
}

/* Edges at any time, from fractions of a clock to silences behind the timeout. */
static void garbage(void)
{
    for (uint32_t n = 1u + dice(300); n > 0; n--) {
        rig.now += (dg_ns)dice(200) << dice(9);
        (void)biss_rig_edge(&rig, dice(2) != 0);
    }
}

/* 40 us of silence and MA high, and the line is in order: every frame and a register of each slave,
   whatever the control frames have been taken for. Only that a command of a slave's took its data
   or its ID away is put right. */
static void test_garbage_on_ma(void **state)
{
    static const uint8_t counts[] = {1, 1, 2, 3};

    const uint32_t rounds = effort(80, 400);
    (void)state;
    for (uint32_t round = 0; round < rounds; round++) {
        struct dg_biss_model figures = *dg_biss_model_of(dg_device_find("s3674-biss"));
        const uint8_t count = counts[round % 4u];

        noise = round * 7919u + 1u;
        figures.singleturn_bits = 12;
        figures.stop_bit_early = (round & 4u) != 0;
        figures.sl_low_at_start = (round & 8u) != 0;
        figures.busy_jitter = DG_US(dice(30));
        assert_int_equal(biss_rig_init(&rig, &figures, count), DG_OK);
        assert_int_equal(biss_rig_power_on(&rig), DG_OK);
        rig.half_ns = 50u + dice(800);
        garbage();
        rig.now += 40000;
        (void)biss_rig_edge(&rig, true);
        rig.now += 40000;
        (void)biss_rig_command(&rig, 0, 1);
        for (uint8_t id = 0; id < count; id++) {
            uint8_t bytes[3] = {0};
            const int n = biss_rig_read(&rig, id, 0x7E, bytes, 3);
            assert_int_equal(n, 2);
            assert_memory_equal(bytes, "\x4B\x55", 2);
            assert_int_equal(biss_rig_read(&rig, id, 0x48, bytes, 1), BISS_RIG_REFUSED);
            assert_true(rig.slave[id].channel_off ||
                        rig.slave[id].line.length == figures.singleturn_bits + 14u);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_traffic),
        cmocka_unit_test(test_garbage_on_ma),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
