/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/world.h"

__extension__ typedef __int128 wide;

/** A shaft that is at one angle before a moment and at another from it on. */
struct jump {
    dg_ns at;
    dg_angle before;
    dg_angle after;
};

static dg_angle jump_angle(void *ctx, dg_ns now)
{
    const struct jump *jump = ctx;

    return now < jump->at ? jump->before : jump->after;
}

/** The angle is the time itself. */
static dg_angle clock_angle(void *ctx, dg_ns now)
{
    (void)ctx;
    return (dg_angle)now;
}

static int32_t speed_of_travel(dg_angle from, dg_angle to)
{
    struct jump jump = {.at = DG_MS(5), .before = from, .after = to};
    struct dg_world world;

    dg_world_init(&world);
    world.angle = jump_angle;
    world.angle_ctx = &jump;
    return dg_world_speed_mrpm(&world, DG_MS(5));
}

/** travel / 2^32 turns in 1 ms, in 0.001 rpm, truncated and saturated. */
static int32_t exact_speed(wide travel)
{
    wide mrpm = travel * 60000000 / DG_TURN;

    if (mrpm > INT32_MAX) {
        return INT32_MAX;
    }
    return mrpm < -INT32_MAX ? -INT32_MAX : (int32_t)mrpm;
}

static void a_new_world_is_healthy_and_at_rest(void **state)
{
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    assert_true(dg_world_angle(&world, 0) == 0);
    assert_true(dg_world_angle(&world, DG_NEVER) == 0);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_S(1)), 0);
    assert_int_equal(world.temperature_mdegc, 37000);
    assert_int_equal(world.led_current_ua, 12000);
    assert_int_equal(world.supply_mv, 5000);
    assert_int_equal(world.battery_mv, 3610);
    assert_int_equal(world.sin_amplitude_permille, 1000);
    assert_int_equal(world.cos_amplitude_permille, 1000);
    assert_int_equal(world.sin_offset_permille, 0);
    assert_int_equal(world.cos_offset_permille, 0);
    assert_true(world.singleturn_ok);
    assert_true(world.multiturn_amplitude_ok);
    assert_true(world.multiturn_sync_ok);
    assert_true(world.multiturn_vector_ok);
    assert_true(world.eeprom_acknowledges);
    assert_false(world.watchdog_fired);
}

static void angle_is_asked_at_now(void **state)
{
    struct jump jump = {.at = 100, .before = -7, .after = INT64_MIN};
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    world.angle = jump_angle;
    world.angle_ctx = &jump;
    assert_true(dg_world_angle(&world, 99) == -7);
    assert_true(dg_world_angle(&world, 100) == INT64_MIN);
}

static void speed_is_the_travel_of_the_last_millisecond(void **state)
{
    struct jump jump = {.at = DG_MS(5), .before = 0, .after = DG_TURN};
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    world.angle = jump_angle;
    world.angle_ctx = &jump;
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(5) - 1), 0);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(5)), 60000000);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(6) - 1), 60000000);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(6)), 0);
}

static void the_first_millisecond_counts_for_every_moment_in_it(void **state)
{
    struct jump jump = {.at = DG_MS(1), .before = 0, .after = -DG_TURN};
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    world.angle = jump_angle;
    world.angle_ctx = &jump;
    assert_int_equal(dg_world_speed_mrpm(&world, 0), -60000000);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(1) - 1), -60000000);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(1)), -60000000);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(2) - 1), -60000000);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_MS(2)), 0);
    jump.at = DG_US(300); /* in the first millisecond, but not in the one before 1.3 ms */
    assert_int_equal(dg_world_speed_mrpm(&world, DG_US(1299)), -60000000);
    assert_int_equal(dg_world_speed_mrpm(&world, DG_US(1300)), 0);
}

static void speed_is_truncated_towards_zero(void **state)
{
    (void)state;
    assert_int_equal(speed_of_travel(0, 71), 0); /* 2^32 / 6e7 = 71.58 */
    assert_int_equal(speed_of_travel(0, 72), 1);
    assert_int_equal(speed_of_travel(0, -71), 0);
    assert_int_equal(speed_of_travel(0, -72), -1);
    assert_int_equal(speed_of_travel(0, -143), -1);
    assert_int_equal(speed_of_travel(0, -144), -2);
}

static void speed_saturates(void **state)
{
    /* 2^31-1 begins at 35.79 turns in the millisecond. */
    dg_angle limit = (dg_angle)(((wide)INT32_MAX * DG_TURN + 59999999) / 60000000);

    (void)state;
    assert_int_equal(speed_of_travel(0, limit - 1), INT32_MAX - 1);
    assert_int_equal(speed_of_travel(0, limit), INT32_MAX);
    assert_int_equal(speed_of_travel(0, 36 * DG_TURN - 1), INT32_MAX);
    assert_int_equal(speed_of_travel(0, 36 * DG_TURN), INT32_MAX);
    assert_int_equal(speed_of_travel(0, 72 * DG_TURN), INT32_MAX); /* 2^64 / 6e7 = 71.6 turns */
    assert_int_equal(speed_of_travel(0, INT64_MAX), INT32_MAX);
    assert_int_equal(speed_of_travel(0, 1 - limit), -INT32_MAX + 1);
    assert_int_equal(speed_of_travel(0, -limit), -INT32_MAX);
    assert_int_equal(speed_of_travel(0, INT64_MIN), -INT32_MAX);
}

static void speed_is_right_where_the_angle_wraps(void **state)
{
    (void)state;
    assert_int_equal(speed_of_travel(INT64_MAX - DG_TURN / 2 + 1, INT64_MIN + DG_TURN / 2),
                     60000000);
    assert_int_equal(speed_of_travel(INT64_MIN, INT64_MAX - DG_TURN + 1), -60000000);
}

static void speed_agrees_with_unbounded_integers(void **state)
{
    uint64_t seed = 1;

    (void)state;
    for (int i = 0; i < 200000; i++) {
        dg_angle from;
        dg_angle to;

        seed = seed * 6364136223846793005u + 1442695040888963407u;
        from = (dg_angle)(seed >> 2) - ((dg_angle)1 << 61);
        /* Travels of every length up to 64 turns, in both directions. */
        to = from + (dg_angle)(seed >> (26 + (seed >> 32) % 38));
        assert_int_equal(speed_of_travel(from, to), exact_speed((wide)to - from));
        assert_int_equal(speed_of_travel(to, from), exact_speed((wide)from - to));
    }
}

static void two_worlds_share_one_shaft(void **state)
{
    struct dg_world a;
    struct dg_world b;

    (void)state;
    dg_world_init(&a);
    a.angle = clock_angle;
    b = a;
    b.temperature_mdegc = -40000;
    assert_true(dg_world_angle(&a, 1234567) == 1234567);
    assert_true(dg_world_angle(&b, 1234567) == 1234567);
    assert_int_equal(dg_world_speed_mrpm(&b, DG_S(1)), 13969); /* 1e6 * 6e7 / 2^32 = 13969.8 */
    assert_int_equal(a.temperature_mdegc, 37000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_new_world_is_healthy_and_at_rest),
        cmocka_unit_test(angle_is_asked_at_now),
        cmocka_unit_test(speed_is_the_travel_of_the_last_millisecond),
        cmocka_unit_test(the_first_millisecond_counts_for_every_moment_in_it),
        cmocka_unit_test(speed_is_truncated_towards_zero),
        cmocka_unit_test(speed_saturates),
        cmocka_unit_test(speed_is_right_where_the_angle_wraps),
        cmocka_unit_test(speed_agrees_with_unbounded_integers),
        cmocka_unit_test(two_worlds_share_one_shaft),
    };

    return cmocka_run_group_tests_name("world", tests, NULL, NULL);
}
