/* SPDX-License-Identifier: MIT */
/*
 * Supervision of the F36x8: every warning and alarm by its physical cause, with EMCY, error
 * register and 1029h; temperature, battery, operating time (manual chapters 14, 15, 26; C14-C16,
 * C22, C23).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "cia406_private.h"
#include "co_rig.h"

#define EMCY 0x0BF
#define TPDO1 0x1BF
#define LOOK DG_MS(100)
#define START 0x01
#define SAVE 0x65766173u

static const struct dg_cia406_model f3658 = {.turns = 1, .device = &dg_cia406_singleturn};
static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    co_rig_run(&rig, LOOK);
    co_rig_forget(&rig);
    return 0;
}

static void turn_at(int32_t mrpm)
{
    rig.motion = (struct dg_motion){.kind = DG_MOTION_SPEED, .start = rig.now, .mrpm = mrpm};
}

static void too_fast(void)
{
    turn_at(12100000);
    co_rig_run(&rig, DG_MS(99));
}

static void too_fast_backwards(void)
{
    turn_at(-12100000);
    co_rig_run(&rig, DG_MS(99));
}

static void too_hot(void)
{
    rig.world.temperature_mdegc = 99000;
}

static void too_cold(void)
{
    rig.world.temperature_mdegc = -32001;
}

static void battery_low(void)
{
    rig.world.battery_mv = 2399;
}

static void battery_off(void)
{
    rig.world.battery_mv = 0;
}

static void led_current_high(void)
{
    rig.world.led_current_ua = 30001;
}

static void singleturn_bad(void)
{
    rig.world.singleturn_ok = false;
}

static void multiturn_amplitude_bad(void)
{
    rig.world.multiturn_amplitude_ok = false;
}

static void multiturn_sync_bad(void)
{
    rig.world.multiturn_sync_ok = false;
}

static void multiturn_vector_bad(void)
{
    rig.world.multiturn_vector_ok = false;
}

static void watchdog_fired(void)
{
    rig.world.watchdog_fired = true;
}

static void memory_silent(void)
{
    rig.world.eeprom_acknowledges = false;
}

enum class_of { NONE, DEVICE = 2, MANUFACTURER = 3 };

/* clang-format off */
static const struct row {
    void (*begin)(void);
    const char *emcy;      /* chapter 15; NULL: none */
    uint8_t error_register;
    uint16_t alarms;
    uint16_t warnings;
    enum class_of class_of; /* sub-index of 1029h */
} rows[] = {
    {too_fast,                "00 42 09 80 65 20 A2 2E", 0x09, 0, 0x0001, DEVICE},
    {too_fast_backwards,      "00 42 09 80 65 20 A2 2E", 0x09, 0, 0x0001, DEVICE},
    {too_hot,                 "00 42 09 80 A3 20 A2 2E", 0x09, 0, 0x8000, DEVICE},
    {too_cold,                "00 42 09 80 1F 20 A2 2E", 0x09, 0, 0x8000, DEVICE},
    {battery_low,             "00 32 01 02 EF 00 00 00", 0x01, 0, 0x0010, MANUFACTURER},
    {battery_off,             "00 32 05 02 00 00 00 FF", 0x05, 0, 0x0010, MANUFACTURER},
    {led_current_high,        "00 52 01 09 81 45 00 00", 0x01, 0, 0,      DEVICE},
    {singleturn_bad,          "00 10 01 00 00 00 00 00", 0x01, 1, 0,      DEVICE},
    {multiturn_amplitude_bad, "00 10 01 00 00 00 00 00", 0x01, 1, 0,      DEVICE},
    {multiturn_sync_bad,      "00 10 01 00 00 00 00 00", 0x01, 1, 0,      DEVICE},
    {multiturn_vector_bad,    "00 10 01 00 00 00 00 00", 0x01, 1, 0,      DEVICE},
    {memory_silent,           "00 51 01 00 00 00 00 00", 0x01, 2, 0,      MANUFACTURER},
    {watchdog_fired,          NULL,                      0x00, 0, 0x0004, NONE},
};
/* clang-format on */
#define ROWS DG_COUNT(rows)

static void heal(void)
{
    dg_world_init(&rig.world);
    rig.motion = (struct dg_motion){.kind = DG_MOTION_STANDSTILL};
    rig.world.angle = dg_motion_angle;
    rig.world.angle_ctx = &rig.motion;
}

/* ------------------------------------------------------------ causes */

static void expect_causes(const struct row *row)
{
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), row->error_register);
    assert_int_equal(co_rig_get(&rig, 0x6503, 0), row->alarms);
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), row->warnings);
    assert_int_equal(co_rig_get(&rig, 0x6503, 0) & ~co_rig_get(&rig, 0x6504, 0), 0);
    assert_int_equal(co_rig_get(&rig, 0x6505, 0) & ~co_rig_get(&rig, 0x6506, 0), 0);
}

static void every_cause_begins_and_ends_with_its_emcy(void **state)
{
    static const struct row healthy = {.emcy = NULL};
    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        bool two = rows[i].alarms == 2; /* 5100h, and 1000h for the alarm */
        setup(NULL);
        rows[i].begin();
        co_rig_run(&rig, 2 * LOOK);
        co_rig_expect_count(&rig, rows[i].emcy == NULL ? 0 : two ? 2 : 1);
        if (rows[i].emcy != NULL) {
            co_rig_expect(&rig, 0, EMCY, rows[i].emcy);
        }
        if (two) {
            co_rig_expect(&rig, 1, EMCY, "00 10 01 00 00 00 00 00");
        }
        expect_causes(&rows[i]);
        co_rig_forget(&rig);
        co_rig_run(&rig, DG_S(10));
        co_rig_expect_count(&rig, 0); /* once per event */
        heal();
        co_rig_run(&rig, 2 * LOOK);
        co_rig_expect_count(&rig, rows[i].emcy == NULL ? 0 : 1);
        if (rows[i].emcy != NULL) {
            co_rig_expect(&rig, 0, EMCY, "00 00 00 00 00 00 00 00");
        }
        expect_causes(&healthy);
    }
}

/* 0000h comes with the end of the last cause; the error register holds what lasts. */
static void causes_overlap(void **state)
{
    (void)state;
    battery_off();
    co_rig_run(&rig, LOOK);
    too_hot();
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 2);
    co_rig_expect(&rig, 1, EMCY, "00 42 0D 80 A3 20 A2 2E");
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0x8010);
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0x0D);
    co_rig_forget(&rig);
    rig.world.battery_mv = 3610;
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 0);
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0x09);
    assert_int_equal(co_rig_get(&rig, 0x1003, 0), 2);
    assert_int_equal(co_rig_get(&rig, 0x1003, 1), 0xA3804200);
    assert_int_equal(co_rig_get(&rig, 0x1003, 2), 0x00023200);
}

static void supported_bits(void **state)
{
    (void)state;
    assert_int_equal(co_rig_get(&rig, 0x6504, 0), 0x0003);
    assert_int_equal(co_rig_get(&rig, 0x6506, 0), 0x801D);
}

/* Limits that are just kept are no causes. */
static void limits_belong_to_what_is_allowed(void **state)
{
    (void)state;
    rig.world.temperature_mdegc = 98999;
    rig.world.battery_mv = 2400;
    rig.world.led_current_ua = 30000;
    turn_at(12000000);
    co_rig_run(&rig, DG_S(1));
    rig.world.temperature_mdegc = -32000;
    turn_at(-12000000);
    co_rig_run(&rig, DG_S(1));
    co_rig_expect_count(&rig, 0);
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0);
}

/* From 0.1 V on there is a battery, which is low. */
static void a_tenth_of_a_volt_is_a_battery(void **state)
{
    (void)state;
    rig.world.battery_mv = 100;
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, EMCY, "00 32 01 02 0A 00 00 00");
    rig.world.battery_mv = 99;
    co_rig_forget(&rig);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 2); /* one cause ends, another begins */
    co_rig_expect(&rig, 1, EMCY, "00 32 05 02 00 00 00 FF");
}

/* From above 12000 rpm until 11880: one EMCY, and bits that agree with it. */
static void too_fast_has_a_hysteresis(void **state)
{
    static const int32_t still_too_fast[] = {12001000, 12000000, 11881000, 12000000, -11900000};
    (void)state;
    co_rig_forget(&rig);
    for (size_t i = 0; i < DG_COUNT(still_too_fast); i++) {
        turn_at(still_too_fast[i]);
        co_rig_run(&rig, DG_S(1));
        co_rig_expect_count(&rig, 1);
        assert_int_equal(rig.node.active_causes, 1u << CAUSE_SPEED);
    }
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 1);
    assert_int_equal(co_rig_get(&rig, 0x2120, 1), 0x80);
    co_rig_forget(&rig);
    turn_at(-11880000);
    co_rig_run(&rig, DG_S(1));
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, EMCY, "00 00 00 00 00 00 00 00");
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0);
    turn_at(12000000);
    co_rig_run(&rig, DG_S(1));
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0);
}

static void a_singleturn_has_no_battery_and_another_speed_limit(void **state)
{
    (void)state;
    co_rig_start_model(&rig, &f3658);
    battery_off();
    multiturn_amplitude_bad();
    multiturn_sync_bad();
    multiturn_vector_bad();
    turn_at(4000000);
    co_rig_run(&rig, DG_S(1));
    co_rig_expect_count(&rig, 0);
    assert_int_equal(co_rig_get(&rig, 0x6503, 0), 0);
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0);
    assert_int_equal(co_rig_get(&rig, 0x2125, 0), 0x3FF);
    co_rig_start_model(&rig, &f3658); /* from rest, so that nothing jumps */
    turn_at(4001000);
    co_rig_run(&rig, DG_S(1));
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, EMCY, "00 42 09 80 65 20 A2 2E");
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0x0001);
}

/* ------------------------------------------------------------ 1029h (C14) */

static void the_reaction_is_that_of_the_class(void **state)
{
    static const enum dg_co_state states[] = {DG_CO_PRE_OPERATIONAL, DG_CO_OPERATIONAL,
                                              DG_CO_STOPPED};
    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        for (uint8_t behaviour = 0; behaviour < 3; behaviour++) {
            bool reacts = rows[i].class_of != NONE;
            setup(NULL);
            if (reacts) {
                co_rig_put(&rig, 0x1029, (uint8_t)rows[i].class_of, behaviour, 1);
                co_rig_put(&rig, 0x1029, (uint8_t)(5 - rows[i].class_of), 1, 1);
            }
            co_rig_nmt(&rig, START);
            rows[i].begin();
            co_rig_run(&rig, 2 * LOOK);
            assert_int_equal(rig.node.state, reacts ? states[behaviour] : DG_CO_OPERATIONAL);
            if (reacts) { /* the EMCY goes out before the state that forbids it */
                co_rig_expect(&rig, 0, EMCY, rows[i].emcy);
            }
        }
    }
}

/* The warning is read by a TPDO that the reaction ends: nothing is sent out of Operational. */
static void a_reaction_ends_the_tpdo_that_shows_its_cause(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x1800, 1, 0x800001BF, 4);
    co_rig_put(&rig, 0x1A00, 0, 0, 1);
    co_rig_put(&rig, 0x1A00, 1, 0x65050010, 4);
    co_rig_put(&rig, 0x1A00, 0, 1, 1);
    co_rig_put(&rig, 0x1800, 5, 7, 2);
    co_rig_put(&rig, 0x1800, 1, 0x000001BF, 4);
    co_rig_put(&rig, 0x1029, 2, 0, 1);
    co_rig_nmt(&rig, START);
    too_hot();
    co_rig_run(&rig, LOOK);
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL);
    co_rig_expect(&rig, 0, TPDO1, "00 80"); /* at once, before the EMCY */
    for (uint32_t i = 0, emcys = 0; i < rig.count; i++) {
        emcys += rig.frame[i].id == EMCY;
        assert_true(emcys == 0 || rig.frame[i].id != TPDO1);
        assert_true(i + 1 < rig.count || emcys == 1);
    }
}

/* ------------------------------------------------------------ 2110h, 2120h (C22), 2125h (C23) */

static void temperature_codes(void **state)
{
    static const struct {
        int32_t mdegc;
        uint32_t code;
    } codes[] = {
        {-20000, 0x2C}, {0, 0x40},      {25000, 0x59},  {49000, 0x71},     {100000, 0xA4},
        {999, 0x40},    {-1, 0x3F},     {-1000, 0x3F},  {-1001, 0x3E},     {-64000, 0x00},
        {-65000, 0x00}, {191000, 0xFF}, {192000, 0xFF}, {INT32_MIN, 0x00}, {INT32_MAX, 0xFF},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(codes); i++) {
        rig.world.temperature_mdegc = codes[i].mdegc;
        assert_int_equal(co_rig_get(&rig, 0x2120, 4), codes[i].code);
    }
}

static void temperature_limits(void **state)
{
    (void)state;
    for (uint8_t sub = 2; sub <= 3; sub++) {
        uint32_t before = co_rig_get(&rig, 0x2120, sub);
        assert_int_equal(co_rig_write(&rig, 0x2120, sub, 0x1F, 1), DG_CO_RANGE);
        assert_int_equal(co_rig_write(&rig, 0x2120, sub, 0xAD, 1), DG_CO_RANGE);
        assert_int_equal(co_rig_get(&rig, 0x2120, sub), before);
    }
    co_rig_put(&rig, 0x2120, 3, 0xAC, 1);
    co_rig_put(&rig, 0x2120, 2, 0xAC, 1);
    co_rig_put(&rig, 0x2120, 3, 0x20, 1);
    co_rig_put(&rig, 0x2120, 2, 0x20, 1);
    co_rig_put(&rig, 0x2120, 3, 0xA2, 1);
    assert_int_equal(co_rig_write(&rig, 0x2120, 4, 0x50, 1), DG_CO_READ_ONLY);
    assert_int_equal(co_rig_write(&rig, 0x2120, 1, 0, 1), DG_CO_READ_ONLY);
    co_rig_put(&rig, 0x2120, 2, 0x50, 1); /* 16 degC */
    co_rig_put(&rig, 0x2120, 3, 0x60, 1); /* 32 degC */
    rig.world.temperature_mdegc = 32999;
    co_rig_run(&rig, LOOK);
    co_rig_forget(&rig);
    rig.world.temperature_mdegc = 33000;
    co_rig_run(&rig, LOOK);
    co_rig_expect(&rig, 0, EMCY, "00 42 09 80 61 50 60 2E");
    assert_int_equal(co_rig_get(&rig, 0x2120, 1), 0x80);
    rig.world.temperature_mdegc = 16000;
    co_rig_run(&rig, LOOK);
    assert_int_equal(co_rig_get(&rig, 0x2120, 1), 0x00);
    co_rig_forget(&rig);
    rig.world.temperature_mdegc = 15999;
    co_rig_run(&rig, LOOK);
    co_rig_expect(&rig, 0, EMCY, "00 42 09 80 4F 50 60 2E");
}

static void sensor_configuration_can_only_be_read(void **state)
{
    (void)state;
    assert_int_equal(co_rig_get(&rig, 0x2110, 0), 2);
    assert_int_equal(co_rig_get(&rig, 0x2110, 1), 16);
    assert_int_equal(co_rig_get(&rig, 0x2110, 2), 12);
    assert_int_equal(co_rig_write(&rig, 0x2110, 1, 13, 1), DG_CO_READ_ONLY);
    co_rig_start_model(&rig, &f3658);
    assert_int_equal(co_rig_get(&rig, 0x2110, 2), 0);
}

static void battery_voltage(void **state)
{
    static const struct {
        uint32_t mv;
        uint32_t value;
    } values[] = {
        {3610, 361}, {3619, 361}, {2400, 240}, {2399, 239}, {5000, 500},       {5010, 500},
        {9999, 500}, {100, 10},   {99, 0x3FF}, {0, 0x3FF},  {UINT32_MAX, 500},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(values); i++) {
        rig.world.battery_mv = values[i].mv;
        assert_int_equal(co_rig_get(&rig, 0x2125, 0), values[i].value);
    }
}

/* ------------------------------------------------------------ 6508h */

/* Longer than every deadline on the way could be served. */
static void pass(dg_ns span)
{
    rig.now += span;
    (void)dg_co_step(&rig.node, rig.now);
}

static void power_cycle(void)
{
    dg_co_power_off(&rig.node);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
}

static void operating_time_survives_power_off(void **state)
{
    (void)state;
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 0);
    pass(DG_S(359));
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 0);
    pass(DG_S(1));
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 1);
    pass(DG_S(3600));
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 11);
    memory_silent();
    pass(DG_S(3600));
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 21);
    rig.world.eeprom_acknowledges = true;
    pass(DG_S(360));
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 22);
    rig.now += DG_S(86400); /* off */
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 22);
}

/* Whoever reads it between two looks of the supervision is told what it is by then. */
static void operating_time_is_that_of_the_request(void **state)
{
    (void)state;
    pass(rig.encoder.time_from + DG_S(360) - DG_MS(50) - rig.now);
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 0);
    rig.now += DG_MS(50);
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 1);
}

static void an_old_encoder_warns(void **state)
{
    (void)state;
    pass(DG_S(3600) * 100000u);
    assert_int_equal(co_rig_get(&rig, 0x6508, 0), 1000000);
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0);
    pass(DG_S(360));
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0x0008);
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x6505, 0), 0x0008);
}

/* A power cut costs the tenth of an hour that was being written, no more. */
static void operating_time_and_power_cuts(void **state)
{
    (void)state;
    for (int tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
        for (uint32_t nth = 0;; nth++) {
            uint32_t before = co_rig_get(&rig, 0x6508, 0);
            ram_nvm_cut(&rig.nvm, nth, (enum ram_nvm_tear)tear, 1);
            pass(DG_S(360));
            bool cut = rig.nvm.dead;
            ram_nvm_restore(&rig.nvm);
            power_cycle();
            uint32_t after = co_rig_get(&rig, 0x6508, 0);
            assert_true(after == before + 1 || (cut && after == before));
            if (!cut) {
                assert_true(nth >= 3);
                break;
            }
        }
    }
}

/* ------------------------------------------------------------ damaged parameters */

static void damaged_parameters_say_5100h_until_they_are_saved_again(void **state)
{
    const struct dg_store_layout *layout = rig.model->device->layout;
    (void)state;
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    int region = dg_store_find(layout, "profile");
    assert_true(region >= 0);
    rig.nvm.bytes[dg_store_address(layout, (uint8_t)region)] ^= 1;
    co_rig_forget(&rig);
    power_cycle();
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 2);
    co_rig_expect(&rig, 0, 0x73F, "00");
    co_rig_expect(&rig, 1, EMCY, "00 51 01 00 00 00 00 00");
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0x01);
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    co_rig_forget(&rig);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, EMCY, "00 00 00 00 00 00 00 00");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(every_cause_begins_and_ends_with_its_emcy, setup),
        cmocka_unit_test_setup(causes_overlap, setup),
        cmocka_unit_test_setup(supported_bits, setup),
        cmocka_unit_test_setup(limits_belong_to_what_is_allowed, setup),
        cmocka_unit_test_setup(a_tenth_of_a_volt_is_a_battery, setup),
        cmocka_unit_test_setup(too_fast_has_a_hysteresis, setup),
        cmocka_unit_test_setup(a_singleturn_has_no_battery_and_another_speed_limit, setup),
        cmocka_unit_test_setup(the_reaction_is_that_of_the_class, setup),
        cmocka_unit_test_setup(a_reaction_ends_the_tpdo_that_shows_its_cause, setup),
        cmocka_unit_test_setup(temperature_codes, setup),
        cmocka_unit_test_setup(temperature_limits, setup),
        cmocka_unit_test_setup(sensor_configuration_can_only_be_read, setup),
        cmocka_unit_test_setup(battery_voltage, setup),
        cmocka_unit_test_setup(operating_time_survives_power_off, setup),
        cmocka_unit_test_setup(operating_time_is_that_of_the_request, setup),
        cmocka_unit_test_setup(an_old_encoder_warns, setup),
        cmocka_unit_test_setup(operating_time_and_power_cuts, setup),
        cmocka_unit_test_setup(damaged_parameters_say_5100h_until_they_are_saved_again, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
