/* SPDX-License-Identifier: MIT */
/*
 * Speed and acceleration of the F36x8 (manual chapters 13, 26; C17-C19) against the analytic
 * motion: the mean over the integration window, within one count at its ends, to nearest.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "co_rig.h"

#define CCW 0x0001u
#define UNITS_PER_S 0x2000u
#define STEPS 65536.0
#define TWO_PI 6.283185307179586

static const struct dg_cia406_model f3658 = {.turns = 1, .device = &dg_cia406_singleturn};
static const uint32_t windows_ms[] = {1, 10, 100, 200};
static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    return 0;
}

static int16_t speed(void)
{
    return (int16_t)co_rig_get(&rig, 0x6030, 1);
}

static int16_t acceleration(void)
{
    return (int16_t)co_rig_get(&rig, 0x6040, 1);
}

/* ------------------------------------------------------------ analytic motions, in turns */

/* `t` in seconds since the start of the motion. */
static double turns_at(const struct dg_motion *motion, double t)
{
    double turns_per_s = motion->mrpm / 60000.0;
    double accel = (double)motion->accel / 1e9;

    switch (motion->kind) {
    case DG_MOTION_SPEED:
        return turns_per_s * t;
    case DG_MOTION_RAMP:
        return t < accel ? turns_per_s * t * t / (2 * accel) : turns_per_s * (t - accel / 2);
    case DG_MOTION_SINE:
        return (double)motion->amplitude / 4294967296.0 *
               sin(TWO_PI * t / ((double)motion->period / 1e9));
    case DG_MOTION_STANDSTILL:
    case DG_MOTION_REPLAY:
    case DG_MOTION_KIND_COUNT:
        break;
    }
    return 0;
}

/* Turns in the window of `window` seconds that ended at `t`. */
static double way(double t, double window)
{
    return turns_at(&rig.motion, t) - turns_at(&rig.motion, t - window);
}

static double limited(double value, double limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

static void assert_near(double is, double wanted, double tolerance)
{
    if (fabs(is - wanted) > tolerance) {
        fail_msg("%f instead of %f +-%f", is, wanted, tolerance);
    }
}

/* Both values in one unit; `per_turn_s` units of speed are a turn per second. */
static void check(double t, double window, double per_turn_s, double limit)
{
    double sign = (co_rig_get(&rig, 0x6000, 0) & CCW) != 0 ? -1 : 1;
    double count = per_turn_s / STEPS / window;
    double rate = (way(t, window) - way(t - window, window)) / window / window * per_turn_s;

    assert_near(speed(), sign * limited(way(t, window) / window * per_turn_s, limit), 0.5 + count);
    assert_near(acceleration(), sign * limited(rate, 32767), 0.5 + 2 * count / window);
}

/* The motion under way is looked at in every window, unit and code sequence, at odd moments. */
static void check_motion(struct dg_motion motion)
{
    for (uint32_t parameters = 0; parameters < 4; parameters++) {
        bool units = parameters / 2 != 0;
        co_rig_put(&rig, 0x6000, 0, (parameters % 2 ? CCW : 0) | (units ? UNITS_PER_S : 0), 2);
        for (size_t w = 0; w < DG_COUNT(windows_ms); w++) {
            co_rig_put(&rig, 0x6031, 2, windows_ms[w], 2);
            motion.start = rig.now;
            assert_int_equal(dg_motion_set(&rig.motion, &motion), DG_OK);
            co_rig_run(&rig, DG_MS(401));
            for (unsigned i = 0; i < 40; i++) {
                co_rig_run(&rig, DG_US(7321));
                double t = (double)(rig.now - motion.start) / 1e9;
                check(t, windows_ms[w] / 1e3, units ? STEPS : 60, units ? 32767 : 15000);
            }
        }
    }
}

/* ------------------------------------------------------------ tests */

/* Multiples of 75 rpm are whole counts in the window. */
static void turn_at(int32_t mrpm)
{
    rig.motion = (struct dg_motion){.kind = DG_MOTION_SPEED, .start = rig.now, .mrpm = mrpm};
    co_rig_run(&rig, DG_MS(400));
}

static void a_constant_speed(void **state)
{
    static const int32_t mrpm[] = {0, 17, 1000, -1000, 29999, 123456, -7654321, 14999999};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(mrpm); i++) {
        check_motion((struct dg_motion){.kind = DG_MOTION_SPEED, .mrpm = mrpm[i]});
    }
}

static void a_ramp(void **state)
{
    static const int32_t mrpm[] = {3000000, -3000000, 20000};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(mrpm); i++) {
        check_motion((struct dg_motion){
            .kind = DG_MOTION_RAMP, .mrpm = mrpm[i], .accel = DG_MS(550), .hold = DG_NEVER});
    }
}

static void a_sine(void **state)
{
    (void)state;
    check_motion(
        (struct dg_motion){.kind = DG_MOTION_SINE, .amplitude = DG_TURN / 4, .period = DG_S(2)});
    check_motion((struct dg_motion){
        .kind = DG_MOTION_SINE, .amplitude = 50 * DG_TURN, .period = DG_MS(1700)});
}

/* In every window in which a count is less than half an rpm, at whatever moment (C34). */
static void a_constant_speed_reads_constant(void **state)
{
    static const uint32_t windows[] = {10, 100, 200};
    static const int32_t rpm[] = {1, 60, 601, 7777, 11999, 14999, -1, -60, -601, -14999};
    (void)state;
    for (size_t i = 0; i < 3 * DG_COUNT(rpm); i++) {
        const int32_t wanted = rpm[i / 3];
        co_rig_put(&rig, 0x6031, 2, windows[i % 3], 2);
        turn_at(1000 * wanted);
        for (unsigned n = 0; n < 200; n++) {
            co_rig_run(&rig, DG_US(1237));
            assert_int_equal(speed(), wanted);
        }
    }
}

/* The standstill after a movement, and the standstill before the first one. */
static void the_window_forgets(void **state)
{
    (void)state;
    rig.motion = (struct dg_motion){.kind = DG_MOTION_SPEED, .start = rig.now, .mrpm = 600000};
    assert_int_equal(speed(), 0);
    co_rig_run(&rig, DG_MS(50));
    assert_int_equal(speed(), 300);
    co_rig_run(&rig, DG_MS(50));
    assert_int_equal(speed(), 600);
    assert_int_equal(acceleration(), 6000);
    co_rig_run(&rig, DG_MS(100));
    assert_int_equal(acceleration(), 0);
}

/* ------------------------------------------------------------ units, limits */

static void speeds_saturate(void **state)
{
    (void)state;
    turn_at(14025000);
    assert_int_equal(speed(), 14025);
    turn_at(15075000);
    assert_int_equal(speed(), 15000);
    turn_at(-500000000);
    assert_int_equal(speed(), -15000);
    co_rig_put(&rig, 0x6000, 0, UNITS_PER_S, 2);
    assert_int_equal(speed(), -32767);
    co_rig_put(&rig, 0x6000, 0, UNITS_PER_S | CCW, 2);
    assert_int_equal(speed(), 32767);
    co_rig_start_model(&rig, &f3658);
    turn_at(3975000);
    assert_int_equal(speed(), 3975);
    turn_at(4050000);
    assert_int_equal(speed(), 4000);
    turn_at(-4050000);
    assert_int_equal(speed(), -4000);
}

/* A shaft that is put elsewhere is fast, no more. */
static void a_jump_is_a_speed(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x6031, 2, 1, 2);
    co_rig_put(&rig, 0x6031, 3, 65535, 2);
    for (uint32_t parameters = 0; parameters <= UNITS_PER_S; parameters += UNITS_PER_S) {
        const struct dg_motion_point points[] = {{0, INT64_MIN}, {1, INT64_MAX}};
        co_rig_put(&rig, 0x6000, 0, parameters, 2);
        rig.motion = (struct dg_motion){
            .kind = DG_MOTION_REPLAY, .start = rig.now, .points = points, .point_count = 2};
        co_rig_run(&rig, 1);
        assert_int_equal(speed(), parameters != 0 ? 32767 : 15000);
        assert_int_equal(acceleration(), 32767);
        co_rig_run(&rig, DG_MS(1));
        assert_int_equal(speed(), 0);
        assert_int_equal(acceleration(), -32767);
    }
}

/* Chapter 13: the factor is for units/s only. 75 rpm are 81920 counts/s. */
static void multiplier_and_divisor_change_units_per_second(void **state)
{
    static const struct {
        uint16_t multiplier;
        uint16_t divisor;
        int16_t units;
    } rows[] = {
        {1, 2, 32767},         {1, 4, 20480}, {3, 65535, 4},
        {26000, 65535, 32500}, {0, 1, 0},     {1, 65535, 1},
    };
    (void)state;
    turn_at(75000);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        co_rig_put(&rig, 0x6031, 3, rows[i].multiplier, 2);
        co_rig_put(&rig, 0x6031, 4, rows[i].divisor, 2);
        co_rig_put(&rig, 0x6000, 0, UNITS_PER_S, 2);
        assert_int_equal(speed(), rows[i].units);
        co_rig_put(&rig, 0x6000, 0, UNITS_PER_S | CCW, 2);
        assert_int_equal(speed(), -rows[i].units);
        co_rig_put(&rig, 0x6000, 0, 0, 2);
        assert_int_equal(speed(), 75);
    }
}

/* The positions are unscaled ones: scaling and preset do not matter (C17). */
static void scaling_and_preset_do_not_change_the_speed(void **state)
{
    (void)state;
    turn_at(600000);
    co_rig_put(&rig, 0x6001, 0, 10, 4);
    co_rig_put(&rig, 0x6002, 0, 1000, 4);
    co_rig_put(&rig, 0x6000, 0, 0x1004, 2);
    co_rig_put(&rig, 0x6003, 0, 0, 4);
    assert_int_equal(speed(), 600);
}

static void the_parameters_of_6031h(void **state)
{
    static const struct {
        uint8_t sub;
        uint32_t value;
        uint32_t abort;
    } rows[] = {
        {2, 0, DG_CO_RANGE},
        {2, 2, DG_CO_RANGE},
        {2, 50, DG_CO_RANGE},
        {2, 201, DG_CO_RANGE},
        {2, 1000, DG_CO_RANGE},
        {4, 0, DG_CO_RANGE},
        {2, 1, 0},
        {2, 10, 0},
        {2, 100, 0},
        {2, 200, 0},
        {3, 65535, 0},
        {4, 65535, 0},
        {1, 2, 0},
        {5, 1, DG_CO_NO_SUB},
        {0, 4, DG_CO_READ_ONLY},
    };
    uint32_t before[6] = {4, 2, 100, 1, 1, 0};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        uint8_t sub = rows[i].sub;
        assert_int_equal(co_rig_write(&rig, 0x6031, sub, rows[i].value, sub == 0 ? 1 : 2),
                         rows[i].abort);
        before[sub] = rows[i].abort == 0 ? rows[i].value : before[sub];
        for (uint8_t n = 0; n < 5; n++) {
            assert_int_equal(co_rig_get(&rig, 0x6031, n), before[n]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_constant_speed, setup),
        cmocka_unit_test_setup(a_ramp, setup),
        cmocka_unit_test_setup(a_sine, setup),
        cmocka_unit_test_setup(a_constant_speed_reads_constant, setup),
        cmocka_unit_test_setup(the_window_forgets, setup),
        cmocka_unit_test_setup(speeds_saturate, setup),
        cmocka_unit_test_setup(a_jump_is_a_speed, setup),
        cmocka_unit_test_setup(multiplier_and_divisor_change_units_per_second, setup),
        cmocka_unit_test_setup(scaling_and_preset_do_not_change_the_speed, setup),
        cmocka_unit_test_setup(the_parameters_of_6031h, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
