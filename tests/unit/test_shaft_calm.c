/* SPDX-License-Identifier: MIT */
/* How calm a shaft stays, as hosts tell their encoders (world.h, `calm`). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/shaft.h"

/** 1 rev/s, and 1 rev/s in a second. */
#define REV_PER_S 60000
#define REV_PER_S2 60000

static struct dg_shaft make_shaft(int64_t mrpm_per_s)
{
    struct dg_shaft shaft;

    dg_shaft_init(&shaft);
    assert_int_equal(dg_shaft_set_acceleration(&shaft, mrpm_per_s), DG_OK);
    return shaft;
}

/* Not as long as an encoder that looks back sees it turn, and not while nobody can tell. */
static void standing_still(void **state)
{
    static const struct dg_motion rest = {.kind = DG_MOTION_STANDSTILL};
    static const struct dg_motion ramp = {
        .kind = DG_MOTION_RAMP, .mrpm = 1000, .accel = DG_S(1), .hold = DG_S(1)};
    static const struct dg_motion sine = {
        .kind = DG_MOTION_SINE, .amplitude = 1, .period = DG_S(100)};
    struct dg_shaft shaft = make_shaft(REV_PER_S2);
    struct dg_shaft geared;

    (void)state;
    dg_shaft_init(&geared);
    assert_int_equal(dg_shaft_couple(&geared, &shaft, 1, 3), DG_OK);
    assert_int_equal(dg_shaft_calm(&shaft, DG_WORLD_SPEED_SPAN - 1), DG_CALM_UNKNOWN);
    assert_int_equal(dg_shaft_calm(&shaft, DG_WORLD_SPEED_SPAN), DG_CALM_STANDS);
    assert_int_equal(dg_shaft_calm(&geared, DG_WORLD_SPEED_SPAN), DG_CALM_STANDS);
    (void)dg_shaft_set_velocity(&shaft, DG_S(1), REV_PER_S);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(9)), DG_CALM_SLOW);
    (void)dg_shaft_set_velocity(&shaft, DG_S(9), 0);
    const dg_ns settled = dg_shaft_settled(&shaft);
    assert_true(settled > DG_S(9));
    assert_int_equal(dg_shaft_calm(&geared, settled + DG_WORLD_SPEED_SPAN - 1), DG_CALM_SLOW);
    assert_int_equal(dg_shaft_calm(&geared, settled + DG_WORLD_SPEED_SPAN), DG_CALM_STANDS);
    (void)dg_shaft_play(&shaft, DG_S(20), &rest);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(20)), DG_CALM_UNKNOWN); /* it was elsewhere */
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(20) + DG_WORLD_SPEED_SPAN), DG_CALM_STANDS);
    (void)dg_shaft_play(&shaft, DG_S(30), &sine);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(40)), DG_CALM_UNKNOWN);
    (void)dg_shaft_play(&shaft, DG_S(50), &ramp);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(60)), DG_CALM_SLOW);
}

static enum dg_calm calm_at(int32_t mrpm, int32_t numerator, int32_t denominator)
{
    struct dg_shaft shaft = make_shaft(0);
    struct dg_shaft geared;

    dg_shaft_init(&geared);
    assert_int_equal(dg_shaft_couple(&geared, &shaft, numerator, denominator), DG_OK);
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(1), mrpm), DG_OK);
    return dg_shaft_calm(&geared, DG_S(1) + DG_WORLD_SPEED_SPAN);
}

/* Up to the limit, through gears; no product is too large for its type. */
static void turning_slowly(void **state)
{
    (void)state;
    assert_int_equal(calm_at(DG_CALM_MRPM, 1, 1), DG_CALM_SLOW);
    assert_int_equal(calm_at(-DG_CALM_MRPM, 1, 1), DG_CALM_SLOW);
    assert_int_equal(calm_at(DG_CALM_MRPM + 1, 1, 1), DG_CALM_UNKNOWN);
    assert_int_equal(calm_at(-DG_CALM_MRPM - 1, 1, 1), DG_CALM_UNKNOWN);
    assert_int_equal(calm_at(DG_CALM_MRPM * 3, -1, 3), DG_CALM_SLOW);
    assert_int_equal(calm_at(DG_CALM_MRPM * 3 + 1, 1, 3), DG_CALM_UNKNOWN);
    assert_int_equal(calm_at(DG_MOTION_SPEED_MAX_MRPM, INT32_MIN, 1), DG_CALM_UNKNOWN);
    assert_int_equal(calm_at(DG_MOTION_SPEED_MAX_MRPM, 1, INT32_MAX), DG_CALM_SLOW);
}

/* A speed of the last millisecond counts, a speed that is to come, too. */
static void slow_from_when_on(void **state)
{
    struct dg_shaft shaft = make_shaft(0);

    (void)state;
    (void)dg_shaft_set_velocity(&shaft, DG_S(1), DG_CALM_MRPM + 1);
    (void)dg_shaft_set_velocity(&shaft, DG_S(2), DG_CALM_MRPM);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(2) + DG_WORLD_SPEED_SPAN - 1), DG_CALM_UNKNOWN);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(2) + DG_WORLD_SPEED_SPAN), DG_CALM_SLOW);
    (void)dg_shaft_set_acceleration(&shaft, 1000);
    (void)dg_shaft_set_velocity(&shaft, DG_S(3), DG_CALM_MRPM + 1);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(3)), DG_CALM_UNKNOWN);
    (void)dg_shaft_set_velocity(&shaft, DG_S(3), 0);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(4)), DG_CALM_SLOW);
}

/* Who tells where a shaft is tells it in whole units. */
static void it_jumps(void **state)
{
    struct dg_shaft shaft = make_shaft(0);
    struct dg_shaft geared;

    (void)state;
    dg_shaft_init(&geared);
    assert_int_equal(dg_shaft_couple(&geared, &shaft, 1, 1), DG_OK);
    (void)dg_shaft_turn(&shaft, DG_S(1), -1, 0);
    assert_int_equal(dg_shaft_calm(&geared, DG_S(1)), DG_CALM_STANDS);
    (void)dg_shaft_turn(&shaft, DG_S(2), 0, 0);
    assert_int_equal(dg_shaft_calm(&geared, DG_S(2)), DG_CALM_STANDS);
    (void)dg_shaft_turn(&shaft, DG_S(3), DG_TURN / 65536, 0);
    assert_int_equal(dg_shaft_calm(&geared, DG_S(3)), DG_CALM_UNKNOWN);
    assert_int_equal(dg_shaft_calm(&geared, DG_S(4)), DG_CALM_STANDS);
    (void)dg_shaft_set_position(&geared, DG_S(5), DG_TURN);
    assert_int_equal(dg_shaft_calm(&geared, DG_S(5)), DG_CALM_UNKNOWN);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(5)), DG_CALM_STANDS);
    (void)dg_shaft_set_position(&shaft, DG_S(6), -DG_TURN);
    assert_int_equal(dg_shaft_calm(&shaft, DG_S(6)), DG_CALM_UNKNOWN);
    assert_int_equal(dg_shaft_calm(&geared, DG_S(6)), DG_CALM_UNKNOWN);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(standing_still),
        cmocka_unit_test(turning_slowly),
        cmocka_unit_test(slow_from_when_on),
        cmocka_unit_test(it_jumps),
    };
    return cmocka_run_group_tests_name("calm shafts", tests, NULL, NULL);
}
