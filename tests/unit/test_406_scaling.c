/* SPDX-License-Identifier: MIT */
/*
 * Position of the F36x8 without USF: scaling, preset, code sequence, what is refused, what survives
 * power-off (manual chapters 10, 12, 26; C20, C21, C26), against unbounded integers.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "co_rig.h"

#define COMBINATIONS 100000u
#define CCW 0x0001u
#define SCALING 0x0004u
#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu
#define RESET_NODE 0x81

/* No type of the language holds count * MUR exactly for every count. */
__extension__ typedef __int128 wide;

static const struct dg_cia406_model f3658 = {.turns = 1, .device = &dg_cia406_singleturn};
static const struct dg_cia406_model f3668 = {.turns = 4096, .device = &dg_cia406_multiturn};
static const struct dg_cia406_model f3668_32 = {.turns = 65536, .device = &dg_cia406_multiturn_32};
static const struct dg_cia406_model *const models[] = {&f3658, &f3668, &f3668_32};

static struct co_rig rig;
static uint64_t noise;

static int setup(void **state)
{
    (void)state;
    noise = 0x9E3779B97F4A7C15u;
    co_rig_start(&rig);
    return 0;
}

static uint64_t any(void)
{
    noise ^= noise << 13;
    noise ^= noise >> 7;
    noise ^= noise << 17;
    return noise;
}

/* 0..below-1, small values and the ends as likely as the middle. */
static uint64_t some(uint64_t below)
{
    switch (any() % 4) {
    case 0:
        return any() % (below < 8 ? below : 8);
    case 1:
        return below - 1 - any() % (below < 8 ? below : 8);
    default:
        return any() % below;
    }
}

static void turn_to(int64_t counts)
{
    rig.motion.from = dg_angle_of_counts(counts, DG_CIA406_STEPS);
}

/* ------------------------------------------------------------ the model */

struct settings {
    uint32_t parameters;
    uint32_t mur;
    uint64_t tmr;
};

static uint64_t modulo(wide value, uint64_t range)
{
    wide rest = value % (wide)range;

    return (uint64_t)(rest < 0 ? rest + (wide)range : rest);
}

static uint64_t physical(void)
{
    return (uint64_t)rig.model->turns * DG_CIA406_STEPS;
}

static uint64_t range_of(const struct settings *settings)
{
    return (settings->parameters & SCALING) != 0 ? settings->tmr : physical();
}

/* ((GP_U / STA_U) * MUR) % TMR (chapter 26, 6004h). */
static uint64_t scaled(const struct settings *settings, int64_t counts)
{
    bool ccw = (settings->parameters & CCW) != 0;
    wide raw = modulo(ccw ? -(wide)counts : counts, physical());
    wide mur = (settings->parameters & SCALING) != 0 ? settings->mur : DG_CIA406_STEPS;

    return modulo(raw * mur / DG_CIA406_STEPS, range_of(settings));
}

/* FFFFFFFFh stands for 2^32. */
static uint32_t tmr_as_written(uint64_t tmr)
{
    return tmr > UINT32_MAX ? UINT32_MAX : (uint32_t)tmr;
}

static struct settings some_settings(void)
{
    struct settings settings = {
        .parameters = (any() % 2 != 0 ? CCW : 0) | (any() % 8 != 0 ? SCALING : 0),
        .mur = 1u + (uint32_t)some(DG_CIA406_STEPS),
        .tmr = 1u + some(physical()),
    };

    if (any() % 4 == 0) {
        settings.tmr = (uint64_t)settings.mur * (1u + any() % rig.model->turns);
    }
    if (settings.tmr == UINT32_MAX) { /* which only 2^32 has, where it is a choice */
        settings.tmr = physical();
    }
    return settings;
}

static void apply(const struct settings *settings)
{
    co_rig_put(&rig, 0x6000, 0, settings->parameters, 2);
    co_rig_put(&rig, 0x6001, 0, settings->mur, 4);
    co_rig_put(&rig, 0x6002, 0, tmr_as_written(settings->tmr), 4);
}

static int64_t some_counts(void)
{
    int64_t full = (int64_t)physical();
    int64_t overflows = (int64_t)(any() % 64u) - 32;

    return overflows * full + (int64_t)some(physical()) - (int64_t)(any() % 3u);
}

/* ------------------------------------------------------------ tests */

static void check_combination(void)
{
    struct settings settings = some_settings();
    uint64_t range = range_of(&settings);
    uint32_t preset = (uint32_t)some(range > UINT32_MAX ? UINT32_MAX : range);
    int64_t at = some_counts();

    apply(&settings);
    turn_to(at);
    co_rig_put(&rig, 0x6003, 0, preset, 4);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), preset);
    assert_int_equal(co_rig_get(&rig, 0x6500, 0), settings.parameters);
    wide offset = (wide)preset - (wide)scaled(&settings, at);
    assert_int_equal(co_rig_get(&rig, 0x6509, 0), (uint32_t)offset);
    for (unsigned i = 0; i < 3; i++) {
        at = some_counts();
        turn_to(at);
        uint64_t wanted = modulo((wide)scaled(&settings, at) + offset, range);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), wanted);
        assert_int_equal(co_rig_get(&rig, 0x2160, 0), modulo(at, physical()));
    }
}

static void every_combination_agrees_with_unbounded_integers(void **state)
{
    (void)state;
    for (size_t m = 0; m < DG_COUNT(models); m++) {
        co_rig_start_model(&rig, models[m]);
        for (uint32_t i = 0; i < COMBINATIONS / 3 + 1; i++) {
            check_combination();
        }
    }
}

/* A count begins exactly where the angle reaches it, on both sides of zero. */
static void counts_are_floored_angles(void **state)
{
    (void)state;
    for (int64_t count = -3; count <= 3; count++) {
        turn_to(count);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), modulo(count, physical()));
        rig.motion.from--;
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), modulo(count - 1, physical()));
    }
}

static void both_ends_of_the_range(void **state)
{
    (void)state;
    for (size_t m = 0; m < DG_COUNT(models); m++) {
        co_rig_start_model(&rig, models[m]);
        uint32_t last = (uint32_t)(physical() - 1);
        turn_to(-1);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), last);
        co_rig_put(&rig, 0x6003, 0, last, 4);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), last);
        turn_to(0);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0);
        /* Scaling of 1:1 is no scaling; the smallest range there is only has a 0. */
        co_rig_put(&rig, 0x6000, 0, SCALING, 2);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0);
        co_rig_put(&rig, 0x6002, 0, 1, 4);
        turn_to(12345);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0);
        assert_int_equal(co_rig_write(&rig, 0x6003, 0, 1, 4), DG_CO_RANGE);
    }
}

/* 2^32 positions with the highest offset: nothing is lost where the range does not fit 32 bits. */
static void the_full_32_bit_range(void **state)
{
    (void)state;
    co_rig_start_model(&rig, &f3668_32);
    co_rig_put(&rig, 0x6003, 0, UINT32_MAX, 4);
    co_rig_put(&rig, 0x6000, 0, SCALING, 2);
    assert_int_equal(co_rig_get(&rig, 0x6002, 0), UINT32_MAX);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), UINT32_MAX);
    turn_to(1);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0);
}

/* ------------------------------------------------------------ refusals (C26) */

static void what_is_refused_leaves_the_old_value(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t size;
        uint32_t value;
        uint32_t abort;
    } rows[] = {
        {0x6000, 2, 0x0010, DG_CO_RANGE},
        {0x6000, 2, 0x0012, DG_CO_RANGE},
        {0x6000, 2, 0x0800, DG_CO_RANGE},
        {0x6000, 2, 0x1000, DG_CO_INCOMPATIBLE},
        {0x6000, 2, 0x1001, DG_CO_INCOMPATIBLE},
        {0x6000, 4, 0x0004, DG_CO_TOO_LONG},
        {0x6001, 4, 0, DG_CO_RANGE},
        {0x6001, 4, 65537, DG_CO_RANGE},
        {0x6001, 4, UINT32_MAX, DG_CO_RANGE},
        {0x6001, 2, 1000, DG_CO_TOO_SHORT},
        {0x6002, 4, 0, DG_CO_RANGE},
        {0x6002, 4, 0x10000001, DG_CO_RANGE},
        {0x6002, 4, UINT32_MAX, DG_CO_RANGE},
        {0x6003, 4, 36000, DG_CO_RANGE},
        {0x6003, 4, UINT32_MAX, DG_CO_RANGE},
        {0x6004, 4, 1, DG_CO_READ_ONLY},
        {0x6500, 2, 1, DG_CO_READ_ONLY},
        {0x6501, 4, 1, DG_CO_READ_ONLY},
        {0x6502, 2, 1, DG_CO_READ_ONLY},
        {0x6509, 4, 1, DG_CO_READ_ONLY},
    };
    (void)state;
    co_rig_put(&rig, 0x6001, 0, 3600, 4);
    co_rig_put(&rig, 0x6002, 0, 36000, 4);
    co_rig_put(&rig, 0x6000, 0, SCALING, 2);
    co_rig_put(&rig, 0x6003, 0, 35999, 4);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        uint32_t before = co_rig_get(&rig, rows[i].index, 0);
        uint32_t position = co_rig_get(&rig, 0x6004, 0);
        assert_int_equal(co_rig_write(&rig, rows[i].index, 0, rows[i].value, rows[i].size),
                         rows[i].abort);
        assert_int_equal(co_rig_get(&rig, rows[i].index, 0), before);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), position);
    }
}

static void models_that_cannot_be_are_refused(void **state)
{
    static const struct dg_cia406_model wrong[] = {
        {.turns = 0, .device = &dg_cia406_multiturn},
        {.turns = 3, .device = &dg_cia406_multiturn},
        {.turns = 4095, .device = &dg_cia406_multiturn},
        {.turns = 131072, .device = &dg_cia406_multiturn_32},
        {.turns = 4096, .device = NULL},
    };
    static const struct dg_cia406_model good = {.turns = 65536, .device = &dg_cia406_multiturn_32};
    struct dg_cia406 encoder;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(wrong); i++) {
        assert_int_equal(dg_cia406_init(&encoder, &wrong[i]), DG_ERR_ARGUMENT);
    }
    assert_int_equal(dg_cia406_init(&encoder, &good), DG_OK);
}

/* The preset is measured against the range in force: TMR while scaling is on, else the physical. */
static void the_preset_lies_in_the_range_in_force(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x6002, 0, 1000, 4);
    co_rig_put(&rig, 0x6003, 0, 0x0FFFFFFF, 4);
    assert_int_equal(co_rig_write(&rig, 0x6003, 0, 0x10000000, 4), DG_CO_RANGE);
    co_rig_put(&rig, 0x6000, 0, SCALING, 2);
    assert_int_equal(co_rig_write(&rig, 0x6003, 0, 1000, 4), DG_CO_RANGE);
    co_rig_put(&rig, 0x6003, 0, 999, 4);
}

/* ------------------------------------------------------------ 6509h, direction */

static void the_offset_has_the_sign_of_preset_minus_position(void **state)
{
    (void)state;
    turn_to(1000);
    co_rig_put(&rig, 0x6003, 0, 0, 4);
    assert_int_equal((int32_t)co_rig_get(&rig, 0x6509, 0), -1000);
    co_rig_put(&rig, 0x6003, 0, 5000, 4);
    assert_int_equal((int32_t)co_rig_get(&rig, 0x6509, 0), 4000);
    co_rig_put(&rig, 0x6003, 0, 1000, 4);
    assert_int_equal((int32_t)co_rig_get(&rig, 0x6509, 0), 0);
    turn_to(-1);
    co_rig_put(&rig, 0x6003, 0, 0, 4);
    assert_int_equal((int32_t)co_rig_get(&rig, 0x6509, 0), -0x0FFFFFFF);
}

static void the_code_sequence_turns_the_position_round(void **state)
{
    (void)state;
    turn_to(100);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 100);
    co_rig_put(&rig, 0x6000, 0, CCW, 2);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0x10000000 - 100);
    turn_to(-7);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 7);
    turn_to(0);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0);
    co_rig_put(&rig, 0x6003, 0, 10, 4);
    turn_to(3);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 7);
    co_rig_put(&rig, 0x6000, 0, 0, 2);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 13);
}

/* ------------------------------------------------------------ defaults, save, restore */

static void defaults_are_those_of_chapters_10_and_26(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t sub;
        uint32_t value[3]; /* f3658, f3668, f3668 with 65536 turns */
    } rows[] = {
        {0x1000, 0, {0x00010196, 0x00020196, 0x00020196}},
        {0x2100, 0, {5, 5, 5}},
        {0x2101, 0, {0x3F, 0x3F, 0x3F}},
        {0x2102, 0, {1, 1, 1}},
        {0x2105, 0, {1, 1, 1}},
        {0x2120, 2, {0x20, 0x20, 0x20}},
        {0x2120, 3, {0xA2, 0xA2, 0xA2}},
        {0x2140, 1, {0, 0, 0}},
        {0x2140, 4, {0, 0, 0}},
        {0x6000, 0, {0, 0, 0}},
        {0x6001, 0, {65536, 65536, 65536}},
        {0x6002, 0, {65536, 268435456, UINT32_MAX}},
        {0x6003, 0, {0, 0, 0}},
        {0x6031, 1, {2, 2, 2}},
        {0x6031, 2, {100, 100, 100}},
        {0x6031, 3, {1, 1, 1}},
        {0x6031, 4, {1, 1, 1}},
        {0x6200, 0, {0, 0, 0}},
        {0x6400, 1, {0, 0, 0}},
        {0x6401, 1, {0, 0, 0}},
        {0x6401, 2, {0, 0, 0}},
        {0x6402, 1, {65535, 268435455, UINT32_MAX}},
        {0x6402, 2, {65535, 268435455, UINT32_MAX}},
        {0x6500, 0, {0, 0, 0}},
        {0x6501, 0, {65536, 65536, 65536}},
        {0x6502, 0, {1, 4096, 65535}},
        {0x6509, 0, {0, 0, 0}},
        {0x650D, 0, {13, 13, 13}},
        {0x650E, 0, {3, 3, 3}},
    };
    (void)state;
    for (size_t m = 0; m < DG_COUNT(models); m++) {
        co_rig_start_model(&rig, models[m]);
        for (size_t i = 0; i < DG_COUNT(rows); i++) {
            assert_int_equal(co_rig_get(&rig, rows[i].index, rows[i].sub), rows[i].value[m]);
        }
        assert_int_equal(co_rig_get(&rig, 0x6507, 0) & 0xFFFF, 0x0302);
    }
}

static void configure(void)
{
    co_rig_put(&rig, 0x6000, 0, SCALING | CCW, 2);
    co_rig_put(&rig, 0x6001, 0, 3600, 4);
    co_rig_put(&rig, 0x6002, 0, 36000, 4);
    turn_to(-65536 - 32768);
    co_rig_put(&rig, 0x6003, 0, 100, 4);
}

static void power_cycle(void)
{
    dg_co_power_off(&rig.node);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
}

static void saved_scaling_and_preset_survive_power_off(void **state)
{
    (void)state;
    configure();
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    turn_to(-65536 - 32768 - 65536);
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 3700);
    assert_int_equal(co_rig_get(&rig, 0x6003, 0), 100);
    assert_int_equal((int32_t)co_rig_get(&rig, 0x6509, 0), 100 - 5400);
    assert_int_equal(co_rig_get(&rig, 0x6500, 0), SCALING | CCW);
    /* What was not saved since is gone. */
    co_rig_put(&rig, 0x6003, 0, 7, 4);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 7);
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 3700);
}

static void load_brings_the_defaults_back_at_the_next_reset(void **state)
{
    (void)state;
    configure();
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    co_rig_put(&rig, 0x1011, 1, LOAD, 4);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 100);
    co_rig_nmt(&rig, RESET_NODE);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0x10000000 - 65536 - 32768);
    assert_int_equal(co_rig_get(&rig, 0x6002, 0), 268435456);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(every_combination_agrees_with_unbounded_integers, setup),
        cmocka_unit_test_setup(counts_are_floored_angles, setup),
        cmocka_unit_test_setup(both_ends_of_the_range, setup),
        cmocka_unit_test_setup(the_full_32_bit_range, setup),
        cmocka_unit_test(models_that_cannot_be_are_refused),
        cmocka_unit_test_setup(what_is_refused_leaves_the_old_value, setup),
        cmocka_unit_test_setup(the_preset_lies_in_the_range_in_force, setup),
        cmocka_unit_test_setup(the_offset_has_the_sign_of_preset_minus_position, setup),
        cmocka_unit_test_setup(the_code_sequence_turns_the_position_round, setup),
        cmocka_unit_test_setup(defaults_are_those_of_chapters_10_and_26, setup),
        cmocka_unit_test_setup(saved_scaling_and_preset_survive_power_off, setup),
        cmocka_unit_test_setup(load_brings_the_defaults_back_at_the_next_reset, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
