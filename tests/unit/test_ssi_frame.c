/* SPDX-License-Identifier: MIT */
/*
 * Words of SSI: golden ones, both codes, error and parity bit, and taking them apart; what sets the
 * error bit.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ssi_rig.h"

static struct ssi_rig rig;

static uint32_t noise = 7;

static uint32_t random_word(void)
{
    noise = noise * 1664525u + 1013904223u;
    return noise ^ noise >> 15;
}

/* Number and Gray code. */
static void test_gray(void **state)
{
    static const struct {
        uint32_t binary;
        uint32_t gray;
    } rows[] = {
        /* Pilz PSSu E S ABS SSI: 001101 is 9 */
        {9, 0x0D},
        /* diga.me.uk, table of decimal, binary and Gray code */
        {0, 0x00},
        {1, 0x01},
        {2, 0x03},
        {3, 0x02},
        {4, 0x06},
        {5, 0x07},
        {6, 0x05},
        {7, 0x04},
        {8, 0x0C},
        {10, 0x0F},
        {11, 0x0E},
        {12, 0x0A},
        {13, 0x0B},
        {14, 0x09},
        {15, 0x08},
        {16, 0x18},
        {17, 0x19},
        {18, 0x1B},
        {19, 0x1A},
        {20, 0x1E},
        /* by hand: 10011101 */
        {0x9D, 0xD3},
        /* by hand, the ends */
        {0x80000000, 0xC0000000},
        {0xFFFFFFFF, 0x80000000},
        {0x55555555, 0x7FFFFFFF},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_int_equal(dg_ssi_gray(rows[i].binary), rows[i].gray);
        assert_int_equal(dg_ssi_binary(rows[i].gray), rows[i].binary);
    }
    for (uint32_t i = 0; i < 70000; i++) {
        const uint32_t moved = dg_ssi_gray(i) ^ dg_ssi_gray(i + 1u);
        assert_true(moved != 0 && (moved & (moved - 1u)) == 0);
        assert_int_equal(dg_ssi_binary(dg_ssi_gray(i)), i);
    }
}

/* What the encoder sends, and what a master makes of it. */
static void check_word(const struct dg_ssi_model *model, uint32_t position, bool error)
{
    const unsigned bits = ssi_rig_bits(model);
    struct dg_ssi_frame frame;
    uint64_t word = 0;

    assert_int_equal(ssi_rig_init(&rig, model), DG_OK);
    ssi_rig_power_on(&rig);
    rig.angle = (dg_angle)position * (DG_TURN >> model->singleturn_bits);
    rig.world.watchdog_fired = error;
    assert_int_equal(dg_ssi_word_bits(model), bits);
    assert_int_equal(dg_ssi_frame(&rig.device, rig.now, &word), bits);
    assert_int_equal(word, ssi_rig_word(model, position, error));

    const uint64_t noisy = word | (uint64_t)random_word()
                                      << bits; /* what stands above is ignored */
    assert_int_equal(dg_ssi_frame_decode(model, noisy, &frame), DG_OK);
    assert_int_equal(frame.position, position);
    assert_int_equal((uint64_t)frame.multiturn << model->singleturn_bits | frame.singleturn,
                     position);
    assert_int_equal(frame.error, error && model->error_bit != DG_SSI_ERROR_NONE);
    for (unsigned i = 0; i < bits; i++) {
        assert_int_equal(dg_ssi_frame_decode(model, word ^ (uint64_t)1 << i, &frame),
                         model->parity == DG_SSI_PARITY_NONE ? DG_OK : DG_ERR_DAMAGED);
    }
}

/* All widths of a turn, all codes and bits, random positions. */
static void test_all_models(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 24u * 18u * 3u; i++) {
        struct dg_ssi_model model = {.monoflop = DG_SSI_MONOFLOP_NS};
        model.singleturn_bits = (uint8_t)(8u + i % 24u);
        const unsigned most = 32u - model.singleturn_bits;
        model.multiturn_bits = (uint8_t)(i % 5u == 0 ? most : random_word() % (most + 1u));
        if (model.multiturn_bits + model.singleturn_bits < 10) {
            model.multiturn_bits = 2;
        }
        model.code = (uint8_t)(i / 24u % 2u);
        model.error_bit = (uint8_t)(i / 48u % 3u);
        model.parity = (uint8_t)(i / 144u % 3u);
        const unsigned unused = 32u - model.multiturn_bits - model.singleturn_bits;
        check_word(&model, random_word() >> unused, (random_word() & 1u) != 0);
        check_word(&model, 0xFFFFFFFFu >> unused, false);
        check_word(&model, 0, true);
    }
}

/* Each cause sets its own bit, at the first value out of range, and none sets another. */
static void test_causes(void **state)
{
    struct dg_world *world = &rig.world;
    static const struct dg_ssi_model model = {
        .multiturn_bits = 12, .singleturn_bits = 13, .monoflop = DG_SSI_MONOFLOP_NS};
    struct dg_world healthy;

    (void)state;
    assert_int_equal(ssi_rig_init(&rig, &model), 0);
    healthy = rig.world;
    assert_int_equal(dg_ssi_errors(&rig.device), 0);
#define BENT(quantity, value, bit)                                                                 \
    *world = healthy;                                                                              \
    world->quantity = (value);                                                                     \
    assert_int_equal(dg_ssi_errors(&rig.device), (bit))
    BENT(led_current_ua, 30001, DG_SSI_LIGHT);
    BENT(led_current_ua, 30000, 0);
    BENT(sin_amplitude_permille, 1400, 0);
    BENT(cos_amplitude_permille, 600, 0);
    BENT(sin_offset_permille, 100, 0);
    BENT(cos_offset_permille, -100, 0);
    BENT(sin_amplitude_permille, 1401, DG_SSI_SIGNAL);
    BENT(cos_amplitude_permille, 599, DG_SSI_SIGNAL);
    BENT(sin_offset_permille, 101, DG_SSI_SIGNAL);
    BENT(cos_offset_permille, -101, DG_SSI_SIGNAL);
    BENT(temperature_mdegc, -40001, DG_SSI_TEMPERATURE);
    BENT(temperature_mdegc, -40000, 0);
    BENT(temperature_mdegc, 100001, DG_SSI_TEMPERATURE);
    BENT(temperature_mdegc, 100000, 0);
    BENT(supply_mv, 4749, DG_SSI_SUPPLY);
    BENT(supply_mv, 4750, 0);
    BENT(supply_mv, 0, DG_SSI_SUPPLY);
    BENT(supply_mv, 30000, 0);
    BENT(singleturn_ok, false, DG_SSI_SINGLETURN);
    BENT(multiturn_amplitude_ok, false, DG_SSI_MULTITURN);
    BENT(multiturn_sync_ok, false, DG_SSI_MULTITURN);
    BENT(multiturn_vector_ok, false, DG_SSI_MULTITURN);
    BENT(watchdog_fired, true, DG_SSI_SYSTEM);
    BENT(eeprom_acknowledges, false, 0);
    BENT(battery_mv, 0, 0);
#undef BENT
    rig.model.multiturn_bits = 0;
    world->multiturn_sync_ok = false;
    assert_int_equal(dg_ssi_errors(&rig.device), 0);
}

/* Where an angle wraps, and below zero. */
static void test_position(void **state)
{
    static const struct dg_ssi_model model = {
        .multiturn_bits = 12, .singleturn_bits = 13, .monoflop = DG_SSI_MONOFLOP_NS};
    static const struct {
        dg_angle angle;
        uint32_t position;
    } rows[] = {
        {0, 0},
        {DG_TURN / 8192 - 1, 0},
        {DG_TURN / 8192, 1},
        {-1, 0x1FFFFFF},
        {DG_TURN, 0x2000},
        {-DG_TURN, 0x1FFE000},
        {DG_TURN * 4096, 0},
        {DG_TURN * 4095 + DG_TURN / 2, 0x1FFF000},
        {INT64_MAX, 0x1FFFFFF},
        {INT64_MIN, 0},
    };

    (void)state;
    assert_int_equal(ssi_rig_init(&rig, &model), 0);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        rig.angle = rows[i].angle;
        assert_int_equal(dg_ssi_position(&rig.device, 0), rows[i].position);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gray),
        cmocka_unit_test(test_all_models),
        cmocka_unit_test(test_causes),
        cmocka_unit_test(test_position),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
