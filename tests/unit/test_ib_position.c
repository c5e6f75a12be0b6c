/* SPDX-License-Identifier: MIT */
/*
 * Position, presets, shift, direction and speed. Scaling is compared with numbers of any length,
 * worked out digit by digit here.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "ib_rig.h"

#define DIGITS 24

/* A natural number, least significant first, base 65536. */
struct big {
    uint32_t digit[DIGITS];
};

static struct ib_rig rig;
static uint32_t noise;

static uint32_t next(void)
{
    noise = noise * 1664525u + 1013904223u;
    return noise >> 7;
}

static struct big times(struct big a, uint32_t factor)
{
    uint64_t carry = 0;

    for (int i = 0; i < DIGITS; i++) {
        carry += (uint64_t)a.digit[i] * factor;
        a.digit[i] = (uint32_t)(carry & 0xFFFF);
        carry >>= 16;
    }
    assert_true(carry == 0);
    return a;
}

/* Quotient and rest. */
static struct big over(struct big a, uint32_t divisor, uint32_t *rest)
{
    uint64_t left = 0;

    for (int i = DIGITS - 1; i >= 0; i--) {
        left = left << 16 | a.digit[i];
        a.digit[i] = (uint32_t)(left / divisor);
        left %= divisor;
    }
    *rest = (uint32_t)left;
    return a;
}

static uint32_t small(struct big a)
{
    for (int i = 2; i < DIGITS; i++) {
        assert_true(a.digit[i] == 0);
    }
    return a.digit[1] << 16 | a.digit[0];
}

/* floor(raw * S / (U * steps)) modulo floor(S * turns / U) */
static uint32_t expected_position(uint32_t raw, uint32_t steps, uint32_t revolutions)
{
    const struct big one = {.digit = {1}};
    uint32_t rest;
    const struct big counts =
        over(over(times(times(one, raw), steps), revolutions, &rest), rig.model.steps, &rest);
    const struct big range = over(times(times(one, rig.model.turns), steps), revolutions, &rest);

    (void)over(counts, small(range), &rest);
    return rest;
}

static void start_encoder(uint16_t steps, uint16_t turns, bool minus_one)
{
    struct dg_ib_model model = *dg_ib_model_of(dg_device_find("ocd-ib-k3"));

    model.steps = steps;
    model.turns = turns;
    model.steps_minus_one = minus_one;
    assert_int_equal(ib_rig_init(&rig, &model), DG_OK);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
}

static int set_up(void **state)
{
    (void)state;
    start_encoder(4096, 4096, false);
    return 0;
}

static uint32_t set(uint32_t code, uint32_t value)
{
    return ib_rig_send(&rig, code << 24 | value);
}

/* Set steps over revolutions, in either order. @return IN after the release */
static uint32_t pair(uint32_t steps, uint32_t revolutions)
{
    if (steps % 2 == 0) {
        assert_int_equal(set(0x02, steps), 0xC2000000 | steps);
    }
    assert_int_equal(set(0x04, revolutions), 0xC4000000 | revolutions);
    assert_int_equal(set(0x02, steps), 0xC2000000 | steps);
    return ib_rig_release(&rig);
}

static void scale(uint32_t steps, uint32_t revolutions)
{
    assert_int_equal(pair(steps, revolutions) >> 25, 0);
}

static void scaling_is_exact(void **state)
{
    (void)state;
    noise = 1;
    for (int round = 0; round < 1500; round++) {
        const bool minus_one = next() % 4 == 0;
        const uint16_t turns = (uint16_t)(next() % 3 == 0 ? 1 + next() % 4096 : 4096);
        start_encoder(next() % 2 == 0 ? 4096 : 8192, turns, minus_one);
        const uint32_t revolutions = 1 + next() % turns;
        uint32_t most = revolutions * rig.model.steps - (minus_one ? 1 : 0);
        most = most < DG_IB_DATA_MASK ? most : DG_IB_DATA_MASK;
        const uint32_t steps = next() % 5 == 0 ? most : 1 + next() % most;
        scale(steps, revolutions);
        for (int i = 0; i < 20; i++) {
            const uint32_t counts = (uint32_t)rig.model.steps * turns;
            const uint32_t raw = i == 0 ? counts - 1 : next() % counts;
            ib_rig_turn_to(&rig, raw);
            assert_int_equal(ib_rig_cycle(&rig, 0),
                             expected_position(raw, steps + (minus_one ? 1 : 0), revolutions));
        }
    }
}

/* I7, at the limits. */
static void limits(void **state)
{
    (void)state;
    start_encoder(8192, 4096, false);
    assert_int_equal(pair(8193, 1), 0x82000000);
    assert_int_equal(ib_rig_release(&rig), 0);
    scale(0x1FFFFFF, 4096);
    assert_int_equal(pair(0x1FFFFFF, 4095), 0x82000000);
    assert_int_equal(dg_ib_range(&rig.device), 0x1FFFFFF);
    assert_int_equal(ib_rig_release(&rig), 0);
    scale(4095 * 8192, 4095);
    assert_int_equal(dg_ib_range(&rig.device), 8192 * 4096);
    assert_int_equal(pair(4095 * 8192 + 1, 4095), 0x82000000);
    assert_int_equal(ib_rig_release(&rig), 0);
    scale(1, 4095);
    assert_int_equal(dg_ib_range(&rig.device), 1);
    assert_int_equal(set(0x08, 1), 0x82000000);
    assert_int_equal(set(0x0A, 1), 0x82000000);
    assert_int_equal(set(0x08, 0), 0xC8000000);
    start_encoder(4096, 1, true);
    scale(4095, 1);
    assert_int_equal(pair(4096, 1), 0x82000000);
    assert_int_equal(set(0x04, 2), 0x82000000);
    assert_int_equal(set(0x02, 0), 0x82000000);
}

static void direction_turns_the_count(void **state)
{
    (void)state;
    for (int i = -5000; i < 5000; i += 7) {
        ib_rig_turn_to(&rig, i);
        rig.device.direction = 3;
        assert_int_equal(ib_rig_cycle(&rig, 0), (uint32_t)i & 0xFFFFFF);
        rig.device.direction = 4;
        assert_int_equal(ib_rig_cycle(&rig, 0), (uint32_t)-i & 0xFFFFFF);
    }
    assert_int_equal(set(0x06, 3), 0xC6000003);
    assert_int_equal(set(0x06, 4), 0xC6000004);
}

/* I5, I8: in any order, from any position, the preset is what shows. */
static void presets_and_shifts(void **state)
{
    (void)state;
    noise = 2;
    for (int round = 0; round < 300; round++) {
        start_encoder(4096, 4096, false);
        const uint32_t revolutions = 1 + next() % 4096;
        scale(1 + next() % (revolutions * 4096 - 1), revolutions);
        const uint32_t range = dg_ib_range(&rig.device);
        const uint32_t preset = next() % range;
        const uint32_t shift = next() % range;
        ib_rig_turn_to(&rig, next() & 0xFFFFFF);
        (void)set(0x06, 3 + next() % 2);
        (void)set(0x0A, shift);
        (void)set(0x08, preset);
        (void)ib_rig_release(&rig);
        assert_int_equal(ib_rig_send(&rig, 0x40000000), preset);
        assert_int_equal(ib_rig_send(&rig, 0x20210006), 0xA0000000);
        assert_int_equal(ib_rig_send(&rig, 0x20210005), 0xA0000000 | shift);
        (void)ib_rig_send(&rig, 0);
        (void)set(0x0A, 0);
        assert_int_equal(ib_rig_release(&rig), (preset + range - shift) % range);
        ib_rig_turn_to(&rig, next() & 0xFFFFFF);
        assert_int_equal(ib_rig_send(&rig, 0x60000000), preset);
    }
}

static void a_preset_is_activated_once(void **state)
{
    (void)state;
    ib_rig_turn_to(&rig, 1000);
    (void)set(0x08, 0x1234);
    (void)ib_rig_release(&rig);
    assert_int_equal(ib_rig_send(&rig, 0x20210006), 0xA0000001);
    assert_int_equal(ib_rig_send(&rig, 0x40000000), 0x1234);
    ib_rig_turn_to(&rig, 1001);
    assert_int_equal(ib_rig_cycle(&rig, 0x40000000), 0x1235); /* it is no level */
    (void)ib_rig_cycle(&rig, 0);
    assert_int_equal(ib_rig_send(&rig, 0x40000000), 0x1235);
    assert_int_equal(rig.device.counters.presets_unset, 1);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    assert_int_equal(ib_rig_cycle(&rig, 0), 0x1235);
}

/* I5: 60000000h is a level. */
static void the_fraba_preset_holds_the_position(void **state)
{
    (void)state;
    (void)set(0x08, 0x1234);
    (void)ib_rig_release(&rig);
    for (int round = 0; round < 3; round++) {
        (void)ib_rig_cycle(&rig, 0x60000000);
        rig.angle_per_ms = DG_TURN / 64;
        for (int i = 0; i < 50; i++) {
            assert_int_equal(ib_rig_cycle(&rig, 0x60000000), 0x1234);
        }
        assert_int_equal(ib_rig_cycle(&rig, 0), 0x1234);
        assert_int_equal(ib_rig_cycle(&rig, 0), 0x1234 + 64);
        assert_int_equal(ib_rig_cycle(&rig, 0), 0x1234 + 128);
    }
    rig.angle_per_ms = 0;
    const uint32_t position = ib_rig_cycle(&rig, 0);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    assert_int_equal(ib_rig_cycle(&rig, 0), position);
    assert_int_equal(ib_rig_send(&rig, 0x20210006), 0xA0000001); /* 40000000h is still to come */
}

static void speed_in_rpm(void **state)
{
    static const struct {
        int32_t rpm;
        uint32_t in;
    } speeds[] = {{0, 0}, {1, 1}, {-1, 0x1FFFFFF}, {60, 60}, {6000, 6000}, {-11000, 0x1FFD508}};

    (void)state;
    (void)ib_rig_send(&rig, 0x20400001);
    (void)ib_rig_release(&rig);
    for (size_t i = 0; i < DG_COUNT(speeds); i++) {
        rig.angle_per_ms = DG_TURN / 60000 * speeds[i].rpm;
        rig.device.direction = 3;
        assert_int_equal(ib_rig_cycle(&rig, 0), speeds[i].in);
        rig.device.direction = 4;
        assert_int_equal(ib_rig_cycle(&rig, 0), (0u - speeds[i].in) & DG_IB_DATA_MASK);
    }
}

/* I18: bit 31, whatever the mode; above 800 kHz, or without a sensor. */
static void no_valid_position(void **state)
{
    static const uint32_t modes[] = {0x20400000, 0x20400001, 0x20800001};

    (void)state;
    for (size_t i = 0; i < 3; i++) {
        start_encoder(4096, 4096, false);
        bool *const causes[] = {
            &rig.world.singleturn_ok,
            &rig.world.multiturn_amplitude_ok,
            &rig.world.multiturn_sync_ok,
            &rig.world.multiturn_vector_ok,
        };
        (void)ib_rig_send(&rig, modes[i]);
        assert_int_equal(ib_rig_release(&rig) >> 31, 0);
        for (size_t k = 0; k < 4; k++) {
            *causes[k] = false;
            assert_int_equal(ib_rig_cycle(&rig, 0) >> 25, 0x40);
            assert_true(rig.device.invalid);
            *causes[k] = true;
            assert_int_equal(ib_rig_cycle(&rig, 0) >> 25, 0);
        }
        for (int sign = -1; sign <= 1; sign += 2) {
            rig.angle_per_ms = sign * (DG_TURN / 4096 * 800 - 16);
            assert_int_equal(ib_rig_cycle(&rig, 0) >> 31, 0);
            rig.angle_per_ms = sign * (DG_TURN / 4096 * 800 + 1000);
            assert_int_equal(ib_rig_cycle(&rig, 0) >> 31, 1);
        }
    }
    start_encoder(4096, 1, false);
    rig.world.multiturn_sync_ok = false;
    assert_int_equal(ib_rig_cycle(&rig, 0), 0); /* a singleturn has none */
}

static void k1_and_k2(void **state)
{
    (void)state;
    assert_int_equal(ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k1"))), DG_OK);
    assert_int_equal(dg_ib_power_on(&rig.device, rig.now), DG_OK);
    assert_int_equal(ib_rig_cycle(&rig, 0), 0);
    assert_true(rig.device.invalid);
    rig.now += DG_MS(100);
    ib_rig_turn_to(&rig, 4096 * 7 + 0xABC);
    assert_int_equal(ib_rig_cycle(&rig, 0x08000007), 0xABC);
    ib_rig_turn_to(&rig, -1);
    assert_int_equal(ib_rig_send(&rig, 0x20400001), 0xFFF);
    rig.world.singleturn_ok = false;
    assert_int_equal(ib_rig_cycle(&rig, 0), 0xFFF);
    assert_true(rig.device.invalid);
    assert_int_equal(rig.nvm.writes, 0);

    assert_int_equal(ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k2"))), DG_OK);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    ib_rig_turn_to(&rig, -2);
    assert_int_equal(ib_rig_send(&rig, 0x06000004), 0xFFFFFE);
    assert_int_equal(dg_ib_range(&rig.device), 0x1000000);
}

static void without_power_nothing_answers(void **state)
{
    (void)state;
    dg_ib_power_off(&rig.device);
    rig.in = 0x55;
    assert_int_equal(ib_rig_cycle(&rig, 0), 0x55);
    assert_int_equal(dg_ib_leds(&rig.device, rig.now), 0);
}

static void cycle_times(void **state)
{
    (void)state;
    assert_int_equal(dg_ib_bit_times(4, 1), 134);
    assert_int_equal(dg_ib_cycle_time(2, 1, 500000, 0), DG_US(268));
    assert_int_equal(dg_ib_cycle_time(2, 1, 2000000, 0), DG_US(67));
    assert_int_equal(dg_ib_cycle_time(2, 1, 2000000, DG_US(200)), DG_US(267));
    assert_int_equal(dg_ib_cycle_time(7, 4, 500000, 0), DG_US(2 * (13 * 20 + 16)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scaling_is_exact),
        cmocka_unit_test(limits),
        cmocka_unit_test_setup(direction_turns_the_count, set_up),
        cmocka_unit_test(presets_and_shifts),
        cmocka_unit_test_setup(a_preset_is_activated_once, set_up),
        cmocka_unit_test_setup(the_fraba_preset_holds_the_position, set_up),
        cmocka_unit_test_setup(speed_in_rpm, set_up),
        cmocka_unit_test(no_valid_position),
        cmocka_unit_test(k1_and_k2),
        cmocka_unit_test_setup(without_power_nothing_answers, set_up),
        cmocka_unit_test(cycle_times),
    };
    return cmocka_run_group_tests_name("position of an OCD INTERBUS", tests, NULL, NULL);
}
