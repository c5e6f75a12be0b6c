/* SPDX-License-Identifier: MIT */
/* What a course is at moments, and when it is something else. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/course.h"
#include "drehgeber/hal.h"

#define NONE INT32_MIN

static int32_t at(const struct dg_course *course, dg_ns since)
{
    int32_t value = NONE;
    const bool there = dg_course_at(course, since, &value);
    assert_int_equal(there, value != NONE);
    return value;
}

static struct dg_course of(const struct dg_course_point *points, size_t count)
{
    const struct dg_course course = {.points = points, .count = count};
    assert_int_equal(dg_course_check(&course), DG_OK);
    return course;
}

static const struct dg_course_point warm[] = {{DG_S(1), 20000}, {DG_S(11), 85000}};

static void a_line_is_exact_at_every_millisecond(void **state)
{
    const struct dg_course course = of(warm, DG_COUNT(warm));
    (void)state;
    assert_int_equal(at(&course, 0), NONE);
    assert_int_equal(at(&course, DG_S(1) - 1u), NONE);
    assert_int_equal(at(&course, DG_S(1)), 20000);
    /* 6.5 units a millisecond, halves away from the point before */
    assert_int_equal(at(&course, DG_S(1) + DG_MS(1)), 20007);
    assert_int_equal(at(&course, DG_S(1) + DG_MS(2) - 1u), 20007);
    assert_int_equal(at(&course, DG_S(1) + DG_MS(2)), 20013);
    assert_int_equal(at(&course, DG_S(6)), 52500);
    assert_int_equal(at(&course, DG_S(11) - 1u), 84994); /* of 10.999 s: 84993.5 */
    assert_int_equal(at(&course, DG_S(11)), 85000);
    assert_int_equal(at(&course, DG_NEVER), 85000);
}

static void it_changes_when_it_says(void **state)
{
    const struct dg_course course = of(warm, DG_COUNT(warm));
    (void)state;
    assert_int_equal(dg_course_next(&course, 0), DG_S(1));
    assert_int_equal(dg_course_next(&course, DG_S(1)), DG_S(1) + DG_MS(1));
    assert_int_equal(dg_course_next(&course, DG_S(1) + 5u), DG_S(1) + DG_MS(1));
    assert_int_equal(dg_course_next(&course, DG_S(11) - 1u), DG_S(11));
    assert_true(dg_course_next(&course, DG_S(11)) == DG_NEVER);
}

/* A LED that ages: 3 units in ten minutes are three changes, and the end. */
static void nothing_happens_between_units(void **state)
{
    static const struct dg_course_point points[] = {{0, 12000}, {DG_S(600), 11997}};
    const struct dg_course course = of(points, DG_COUNT(points));
    static const struct {
        dg_ns at;
        int32_t value;
    } seen[] = {
        {0, 12000}, {DG_S(100), 11999}, {DG_S(300), 11998}, {DG_S(500), 11997}, {DG_S(600), 11997},
    };
    dg_ns now = 0;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(seen); i++) {
        assert_int_equal(now, seen[i].at);
        assert_int_equal(at(&course, now), seen[i].value);
        now = dg_course_next(&course, now);
    }
    assert_true(now == DG_NEVER);
}

static void a_falling_line_mirrors_a_rising_one(void **state)
{
    static const struct dg_course_point up[] = {{0, -500}, {DG_MS(7), 500}};
    static const struct dg_course_point down[] = {{0, 500}, {DG_MS(7), -500}};
    const struct dg_course rising = of(up, DG_COUNT(up));
    const struct dg_course falling = of(down, DG_COUNT(down));
    (void)state;
    for (unsigned ms = 0; ms < 8; ms++) {
        assert_int_equal(at(&rising, DG_MS(ms)), -at(&falling, DG_MS(ms)));
    }
    assert_int_equal(at(&rising, DG_MS(1)), -357); /* -357.14 */
}

static void steps_hold(void **state)
{
    struct dg_course course = of(warm, DG_COUNT(warm));
    (void)state;
    course.steps = true;
    assert_int_equal(at(&course, DG_S(11) - 1u), 20000);
    assert_int_equal(at(&course, DG_S(11)), 85000);
    assert_int_equal(dg_course_next(&course, DG_S(1)), DG_S(11));
}

static void the_last_point_of_a_moment_counts(void **state)
{
    static const struct dg_course_point points[] = {
        {DG_MS(10), 37}, {DG_MS(10), 90}, {DG_MS(10) + 1u, 200}, {DG_S(1), 200}, {DG_S(1), 37},
    };
    const struct dg_course course = of(points, DG_COUNT(points));
    (void)state;
    assert_int_equal(at(&course, DG_MS(10)), 90);
    assert_int_equal(dg_course_next(&course, DG_MS(10)), DG_MS(10) + 1u); /* off the grid */
    assert_int_equal(at(&course, DG_MS(10) + 1u), 200);
    assert_int_equal(dg_course_next(&course, DG_MS(10) + 1u), DG_S(1));
    assert_int_equal(at(&course, DG_S(1) - 1u), 200);
    assert_int_equal(at(&course, DG_S(1)), 37);
}

static void a_loop_begins_again_at_its_last_point(void **state)
{
    static const struct dg_course_point points[] = {{DG_MS(2), 10}, {DG_MS(12), 20}};
    struct dg_course course = {.points = points, .count = DG_COUNT(points), .loop = true};
    const dg_ns laps = DG_MS(12) * 1000000000000u;
    (void)state;
    assert_int_equal(dg_course_check(&course), DG_OK);
    assert_int_equal(at(&course, DG_MS(1)), NONE);
    assert_int_equal(at(&course, DG_MS(11)), 19);
    assert_int_equal(dg_course_next(&course, DG_MS(11)), DG_MS(12));
    assert_int_equal(at(&course, DG_MS(12)), 20); /* up to the first point of this lap */
    assert_int_equal(dg_course_next(&course, DG_MS(12)), DG_MS(14));
    assert_int_equal(at(&course, DG_MS(14)), 10);
    assert_int_equal(at(&course, laps + DG_MS(7)), 15);
    assert_int_equal(dg_course_next(&course, laps + DG_MS(7)), laps + DG_MS(8));
    assert_true(dg_course_next(&course, DG_NEVER - 1u) > DG_NEVER - 1u);
}

/* A spare one: the longest stretch, and the widest. */
static void nothing_overflows(void **state)
{
    static const struct dg_course_point points[] = {{0, -1000000000}, {DG_NEVER - 1u, 1000000000}};
    const struct dg_course course = of(points, DG_COUNT(points));
    dg_ns now = 0;
    int32_t before = at(&course, 0);
    (void)state;
    for (unsigned i = 0; i < 1000; i++) {
        const dg_ns next = dg_course_next(&course, now);
        assert_true(next > now);
        assert_int_equal(at(&course, next - 1u), before);
        before = at(&course, next);
        now = next + (dg_ns)i * DG_S(10000000);
        before = at(&course, now);
    }
    assert_int_equal(at(&course, (DG_NEVER - 1u) / 2u), 0);
    assert_int_equal(at(&course, DG_NEVER - 2u), 1000000000);
    assert_true(dg_course_next(&course, DG_NEVER - 2u) == DG_NEVER - 1u);
}

/* Whoever steps from change to change sees all there is: the same as looking each millisecond. */
static void stepping_misses_nothing(void **state)
{
    uint32_t random = 1;
    (void)state;
    for (unsigned round = 0; round < 200; round++) {
        struct dg_course_point points[6];
        dg_ns time = 0;
        for (size_t i = 0; i < DG_COUNT(points); i++) {
            random = random * 1664525u + 1013904223u;
            time += (random >> 8) % 4u == 0 ? 0 : (random >> 4) % DG_MS(20);
            points[i] = (struct dg_course_point){time, (int32_t)(random >> 16) % 60 - 30};
        }
        const struct dg_course course = {.points = points,
                                         .count = DG_COUNT(points),
                                         .loop = round % 3u == 0 && time > 0,
                                         .steps = round % 5u == 0};
        assert_int_equal(dg_course_check(&course), DG_OK);
        dg_ns next = 0;
        int32_t value = NONE;
        for (dg_ns now = 0; now < DG_MS(150); now += DG_US(50)) {
            while (next <= now) {
                (void)dg_course_at(&course, next, &value);
                next = dg_course_next(&course, next);
            }
            int32_t wanted = NONE;
            (void)dg_course_at(&course, now, &wanted);
            assert_int_equal(value, wanted);
        }
    }
}

static void what_is_no_course(void **state)
{
    static const struct dg_course_point back[] = {{2, 0}, {1, 0}};
    static const struct dg_course_point still[] = {{0, 0}, {0, 1}};
    const struct dg_course wrong[] = {
        {.points = back, .count = 0},
        {.points = back, .count = 2},
        {.points = still, .count = 2, .loop = true},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(wrong); i++) {
        assert_int_equal(dg_course_check(&wrong[i]), DG_ERR_ARGUMENT);
    }
    assert_int_equal(at(&(struct dg_course){.points = still, .count = 2}, 0), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_is_exact_at_every_millisecond),
        cmocka_unit_test(it_changes_when_it_says),
        cmocka_unit_test(nothing_happens_between_units),
        cmocka_unit_test(a_falling_line_mirrors_a_rising_one),
        cmocka_unit_test(steps_hold),
        cmocka_unit_test(the_last_point_of_a_moment_counts),
        cmocka_unit_test(a_loop_begins_again_at_its_last_point),
        cmocka_unit_test(nothing_overflows),
        cmocka_unit_test(stepping_misses_nothing),
        cmocka_unit_test(what_is_no_course),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
