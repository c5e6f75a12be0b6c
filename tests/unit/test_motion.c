/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/motion.h"
#include "drehgeber/world.h"
#include "effort.h"
#include "motion_model.h"

/** 0.001 rpm in units of 2^-32 turn per nanosecond: 2^32 / 6e13 = 2^18 / MRPM_DIVISOR. */
#define MRPM_DIVISOR 3662109375
#define HOURS_100 DG_S(360000)
#define AMPLITUDE_MAX ((dg_angle)1 << 40)
#define ACCEL_MAX ((uint64_t)1 << 36) /* of random ramps, so that the reference fits 128 bits */

static struct dg_motion accepted(struct dg_motion wanted)
{
    struct dg_motion motion;

    assert_int_equal(dg_motion_set(&motion, &wanted), DG_OK);
    return motion;
}

static void standstill_stays(void **state)
{
    struct dg_motion m = accepted(
        (struct dg_motion){.kind = DG_MOTION_STANDSTILL, .start = 1000, .from = -123456789});

    (void)state;
    assert_true(dg_motion_angle(&m, 0) == -123456789);
    assert_true(dg_motion_angle(&m, 1000) == -123456789);
    assert_true(dg_motion_angle(&m, DG_NEVER) == -123456789);
}

static void speed_starts_at_its_start(void **state)
{
    struct dg_motion m = accepted(
        (struct dg_motion){.kind = DG_MOTION_SPEED, .start = DG_S(10), .from = 77, .mrpm = 60000});

    (void)state;
    assert_true(dg_motion_angle(&m, 0) == 77);
    assert_true(dg_motion_angle(&m, DG_S(10)) == 77);
    assert_true(dg_motion_angle(&m, DG_S(10) + 1) == 77 + 4); /* 4.29 units in a nanosecond */
    assert_true(dg_motion_angle(&m, DG_S(11)) == 77 + DG_TURN);
    m.mrpm = -60000;
    assert_true(dg_motion_angle(&m, DG_S(10) + 1) == 77 - 5); /* floor, not truncation */
    assert_true(dg_motion_angle(&m, DG_S(11)) == 77 - DG_TURN);
    m.mrpm = 0;
    assert_true(dg_motion_angle(&m, DG_NEVER) == 77);
}

/* 12 345.678 rpm for 6000 minutes are 74 074 068 turns, to the last unit. */
static void speed_is_exact_after_100_hours(void **state)
{
    struct dg_motion m = accepted(
        (struct dg_motion){.kind = DG_MOTION_SPEED, .start = 5, .from = 3, .mrpm = 12345678});

    (void)state;
    assert_true(dg_motion_angle(&m, 5 + HOURS_100) == 3 + 74074068 * DG_TURN);
    m.mrpm = -12345678;
    assert_true(dg_motion_angle(&m, 5 + HOURS_100) == 3 - 74074068 * DG_TURN);
    m.mrpm = 1; /* 6 turns in 100 hours */
    assert_true(dg_motion_angle(&m, 5 + HOURS_100) == 3 + 6 * DG_TURN);
    assert_true(dg_motion_angle(&m, 4 + HOURS_100) == 3 + 6 * DG_TURN - 1);
}

static void speed_is_the_exact_floor(void **state)
{
    static const dg_ns edges[] = {0,
                                  1,
                                  MRPM_DIVISOR - 1,
                                  MRPM_DIVISOR,
                                  MRPM_DIVISOR + 1,
                                  HOURS_100,
                                  (dg_ns)1 << 60,
                                  DG_NEVER - 1,
                                  DG_NEVER};
    static const int32_t speeds[] = {
        0, 1, -1, 59999, -12345678, DG_MOTION_SPEED_MAX_MRPM, -DG_MOTION_SPEED_MAX_MRPM};
    static const dg_angle froms[] = {0, -1, INT64_MIN, INT64_MAX};
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 1;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(edges) * DG_COUNT(speeds) * DG_COUNT(froms); i++) {
        dg_ns t = edges[i % DG_COUNT(edges)];
        struct dg_motion m = {.kind = DG_MOTION_SPEED,
                              .from = froms[i / DG_COUNT(edges) / DG_COUNT(speeds)],
                              .mrpm = speeds[i / DG_COUNT(edges) % DG_COUNT(speeds)]};

        assert_true(dg_motion_angle(&m, t) ==
                    wrapped(m.from + floor_div((wide)m.mrpm * t * 262144, MRPM_DIVISOR)));
    }
    for (uint32_t i = 0; i < rounds; i++) {
        dg_ns t = random_up_to(&seed, UINT64_MAX - 1);
        struct dg_motion m = {.kind = DG_MOTION_SPEED,
                              .from = (dg_angle)random_bits(&seed),
                              .mrpm = random_mrpm(&seed)};

        assert_true(dg_motion_angle(&m, t) ==
                    wrapped(m.from + floor_div((wide)m.mrpm * t * 262144, MRPM_DIVISOR)));
    }
}

/* 60 rpm, so a turn a second at the top: 2 s up, 3 s at it, 2 s down. */
static void ramp_by_hand(void **state)
{
    static const struct {
        dg_ns t;
        dg_angle angle;
    } rows[] = {
        {DG_S(0), 0},
        {DG_MS(500), DG_TURN / 16},
        {DG_S(1), DG_TURN / 4},
        {DG_S(2), DG_TURN},
        {DG_S(3), 2 * DG_TURN},
        {DG_S(5), 4 * DG_TURN},
        {DG_S(6), 4 * DG_TURN + DG_TURN * 3 / 4},
        {DG_MS(6500), 5 * DG_TURN - DG_TURN / 16},
        {DG_S(7), 5 * DG_TURN},
        {DG_S(8), 5 * DG_TURN},
        {DG_NEVER - DG_S(9), 5 * DG_TURN},
    };
    struct dg_motion m = accepted((struct dg_motion){.kind = DG_MOTION_RAMP,
                                                     .start = DG_S(9),
                                                     .from = -5,
                                                     .mrpm = 60000,
                                                     .accel = DG_S(2),
                                                     .hold = DG_S(3)});

    (void)state;
    assert_true(dg_motion_angle(&m, 0) == -5);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        m.mrpm = 60000;
        assert_true(dg_motion_angle(&m, DG_S(9) + rows[i].t) == -5 + rows[i].angle);
        m.mrpm = -60000;
        assert_true(dg_motion_angle(&m, DG_S(9) + rows[i].t) == -5 - rows[i].angle);
    }
}

static void ramps_of_hours_are_exact(void **state)
{
    struct dg_motion m = accepted((struct dg_motion){
        .kind = DG_MOTION_RAMP, .mrpm = 3000000, .accel = DG_S(1), .hold = DG_NEVER});

    (void)state;
    /* 50 turns a second, half a second of them lost on the way up. */
    assert_true(dg_motion_angle(&m, HOURS_100) == 18000000 * DG_TURN - 25 * DG_TURN);
    m.hold = HOURS_100 - DG_S(1);
    assert_true(dg_motion_angle(&m, 2 * HOURS_100) == 18000000 * DG_TURN);
    /* The longest ramp at the highest speed: 1e6 rpm / 2 for 60 minutes. */
    m = accepted((struct dg_motion){
        .kind = DG_MOTION_RAMP, .mrpm = DG_MOTION_SPEED_MAX_MRPM, .accel = DG_MOTION_RAMP_MAX});
    assert_true(dg_motion_angle(&m, DG_MOTION_RAMP_MAX) == 30000000 * DG_TURN);
    assert_true(dg_motion_angle(&m, DG_MOTION_RAMP_MAX / 2) == 7500000 * DG_TURN);
    assert_true(dg_motion_angle(&m, 2 * DG_MOTION_RAMP_MAX) == 60000000 * DG_TURN);
}

/** Twice the time at full speed that a ramp is worth at `t`, times its `accel`. */
static wide ramp_area(const struct dg_motion *m, wide t)
{
    wide accel = (wide)m->accel;
    wide hold = (wide)m->hold;
    wide left = 2 * accel + hold - t;

    if (t < accel) {
        return t * t;
    }
    if (t <= accel + hold) {
        return accel * accel + 2 * (t - accel) * accel;
    }
    return 2 * (accel + hold) * accel - (left > 0 ? left * left : 0);
}

/** The exact angle, give or take the 2^-20 ns of travel that the contract allows. */
static void check_ramp(const struct dg_motion *wanted, dg_ns t)
{
    struct dg_motion m = accepted(*wanted);
    wide divisor = (wide)MRPM_DIVISOR * m.accel;
    wide travel = m.mrpm * ramp_area(&m, (wide)t) * 131072;
    wide tolerance = (wide)m.accel * (m.mrpm < 0 ? -m.mrpm : m.mrpm) / 4 + 1;
    wide moved = ((wide)dg_motion_angle(&m, t) - m.from) * divisor;

    assert_true(moved <= travel + tolerance);
    assert_true(moved + divisor > travel - tolerance); /* what floor drops is less than a unit */
}

static void ramp_is_exact(void **state)
{
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 2;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        struct dg_motion m = {.kind = DG_MOTION_RAMP,
                              .from = (dg_angle)random_bits(&seed) / 4,
                              .mrpm = random_mrpm(&seed),
                              .accel = random_up_to(&seed, ACCEL_MAX),
                              .hold = random_up_to(&seed, ACCEL_MAX)};

        check_ramp(&m, random_bits(&seed) % (2 * m.accel + m.hold + 10));
    }
}

/* Ends of `hold` before, at and beyond the end of time. */
static void ramp_survives_any_hold(void **state)
{
    static const dg_ns holds[] = {0,       1, DG_NEVER - DG_S(2), DG_NEVER - DG_S(1), DG_NEVER - 1,
                                  DG_NEVER};
    static const dg_ns times[] = {0,
                                  1,
                                  DG_S(1),
                                  DG_S(3),
                                  HOURS_100,
                                  DG_NEVER - DG_S(1),
                                  DG_NEVER - DG_S(1) / 2,
                                  DG_NEVER - 1,
                                  DG_NEVER};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(holds) * DG_COUNT(times); i++) {
        struct dg_motion m = {.kind = DG_MOTION_RAMP,
                              .mrpm = i % 2 == 0 ? 60 : -60,
                              .accel = DG_S(1),
                              .hold = holds[i / DG_COUNT(times)]};

        check_ramp(&m, times[i % DG_COUNT(times)]);
    }
}

/** Every nanosecond of a ramp: steps in one direction only, none larger than at full speed. */
static void check_every_step(const struct dg_motion *wanted)
{
    struct dg_motion m = accepted(*wanted);
    int64_t direction = m.mrpm < 0 ? -1 : 1;
    int64_t largest = direction * m.mrpm * 262144 / MRPM_DIVISOR + 2;
    dg_angle before = dg_motion_angle(&m, m.start);

    for (dg_ns t = 1; t <= 2 * m.accel + m.hold + 5; t++) {
        dg_angle angle = dg_motion_angle(&m, m.start + t);

        assert_in_range((angle - before) * direction, 0, largest);
        before = angle;
    }
}

static void ramp_is_monotonic_and_continuous(void **state)
{
    static const dg_ns accels[] = {1, 2, 3, 999, 1000};
    static const dg_ns holds[] = {0, 1, 500};
    static const int32_t speeds[] = {
        1, -1, 12345678, -12345678, DG_MOTION_SPEED_MAX_MRPM, -DG_MOTION_SPEED_MAX_MRPM};

    (void)state;
    for (size_t a = 0; a < DG_COUNT(accels); a++) {
        for (size_t h = 0; h < DG_COUNT(holds); h++) {
            for (size_t s = 0; s < DG_COUNT(speeds); s++) {
                check_every_step(&(struct dg_motion){.kind = DG_MOTION_RAMP,
                                                     .start = 17,
                                                     .from = -1000000,
                                                     .mrpm = speeds[s],
                                                     .accel = accels[a],
                                                     .hold = holds[h]});
            }
        }
    }
}

/* A nanosecond to either side of each joint of a long trapezoid. */
static void ramp_is_continuous_at_the_joints(void **state)
{
    uint64_t seed = 3;

    (void)state;
    for (int i = 0; i < 20000; i++) {
        struct dg_motion m =
            accepted((struct dg_motion){.kind = DG_MOTION_RAMP,
                                        .mrpm = random_mrpm(&seed),
                                        .accel = random_up_to(&seed, DG_MOTION_RAMP_MAX),
                                        .hold = random_up_to(&seed, DG_MOTION_RAMP_MAX)});
        dg_ns joints[] = {m.accel, m.accel + m.hold, 2 * m.accel + m.hold};
        int64_t direction = m.mrpm < 0 ? -1 : 1;
        int64_t largest = direction * m.mrpm * 262144 / MRPM_DIVISOR + 2;

        for (size_t j = 0; j < DG_COUNT(joints); j++) {
            dg_angle before = dg_motion_angle(&m, joints[j] - 1);
            dg_angle at = dg_motion_angle(&m, joints[j]);
            dg_angle after = dg_motion_angle(&m, joints[j] + 1);

            assert_in_range((at - before) * direction, 0, largest);
            assert_in_range((after - at) * direction, 0, largest);
        }
    }
}

static void sine_by_hand(void **state)
{
    struct dg_motion m = accepted((struct dg_motion){.kind = DG_MOTION_SINE,
                                                     .start = DG_S(1),
                                                     .from = 1000,
                                                     .amplitude = DG_TURN / 4,
                                                     .period = DG_S(2)});

    (void)state;
    assert_true(dg_motion_angle(&m, 0) == 1000);
    assert_true(dg_motion_angle(&m, DG_S(1)) == 1000);
    assert_true(dg_motion_angle(&m, DG_MS(1500)) == 1000 + DG_TURN / 4);
    assert_true(dg_motion_angle(&m, DG_S(2)) == 1000);
    assert_true(dg_motion_angle(&m, DG_MS(2500)) == 1000 - DG_TURN / 4);
    assert_true(dg_motion_angle(&m, DG_S(3)) == 1000);
    /* 180 000 periods later nothing has drifted. */
    assert_true(dg_motion_angle(&m, HOURS_100 + DG_MS(1500)) == 1000 + DG_TURN / 4);
    m.amplitude = -m.amplitude;
    assert_true(dg_motion_angle(&m, DG_MS(1500)) == 1000 - DG_TURN / 4);
}

static void sine_is_within_its_error(void **state)
{
    const long double two_pi = 6.28318530717958647692528676655900577L;
    const uint32_t rounds = effort(40000, 300000);
    uint64_t seed = 4;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        struct dg_motion m =
            accepted((struct dg_motion){.kind = DG_MOTION_SINE,
                                        .amplitude = (dg_angle)random_up_to(&seed, AMPLITUDE_MAX),
                                        .period = random_up_to(&seed, DG_MOTION_PERIOD_MAX)});
        dg_ns t = random_bits(&seed);
        long double phase = (long double)(t % m.period) / (long double)m.period;
        long double exact = sinl(two_pi * phase) * (long double)m.amplitude;
        long double error = (long double)dg_motion_angle(&m, t) - exact;

        assert_true(fabsl(error) <= (long double)m.amplitude * 0x1p-29L + 1);
        m.amplitude = -m.amplitude;
        assert_true(fabsl((long double)dg_motion_angle(&m, t) + exact) <=
                    (long double)-m.amplitude * 0x1p-29L + 1);
    }
}

static void sine_wraps_with_the_angle(void **state)
{
    struct dg_motion m = accepted((struct dg_motion){
        .kind = DG_MOTION_SINE, .from = INT64_MAX, .amplitude = AMPLITUDE_MAX, .period = 4});

    (void)state;
    assert_true(dg_motion_angle(&m, 1) == INT64_MIN + AMPLITUDE_MAX - 1);
    assert_true(dg_motion_angle(&m, 3) == INT64_MAX - AMPLITUDE_MAX);
}

static void replay_by_hand(void **state)
{
    static const struct dg_motion_point points[] = {
        {100, 1000}, {200, 1100}, {203, 1101}, {210, 1101}, {220, -9}};
    static const struct {
        dg_ns t;
        dg_angle angle;
    } rows[] = {
        {0, 1000},   {99, 1000},  {100, 1000}, {101, 1001}, {199, 1099},         {200, 1100},
        {201, 1100}, {202, 1100}, {203, 1101}, {207, 1101}, {210, 1101},         {211, 990},
        {215, 546},  {219, 102},  {220, -9},   {221, -9},   {DG_NEVER - 50, -9},
    };
    struct dg_motion m = accepted((struct dg_motion){
        .kind = DG_MOTION_REPLAY, .start = 50, .points = points, .point_count = DG_COUNT(points)});

    (void)state;
    assert_true(dg_motion_angle(&m, 0) == 1000);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_true(dg_motion_angle(&m, 50 + rows[i].t) == rows[i].angle);
    }
}

static void replay_of_one_point(void **state)
{
    static const struct dg_motion_point point = {10, 5};
    struct dg_motion m =
        accepted((struct dg_motion){.kind = DG_MOTION_REPLAY, .points = &point, .point_count = 1});

    (void)state;
    assert_true(dg_motion_angle(&m, 0) == 5);
    assert_true(dg_motion_angle(&m, 10) == 5);
    assert_true(dg_motion_angle(&m, DG_NEVER) == 5);
}

/* Lines over the whole range of both types, downwards and upwards. */
static void replay_spans_both_types(void **state)
{
    static const struct dg_motion_point points[] = {
        {0, INT64_MAX}, {1, INT64_MIN}, {DG_NEVER, INT64_MAX}};
    struct dg_motion m = accepted((struct dg_motion){
        .kind = DG_MOTION_REPLAY, .points = points, .point_count = DG_COUNT(points)});
    uint64_t seed = 5;

    (void)state;
    assert_true(dg_motion_angle(&m, 0) == INT64_MAX);
    assert_true(dg_motion_angle(&m, DG_NEVER) == INT64_MAX);
    for (int i = 0; i < 1000; i++) {
        dg_ns t = random_up_to(&seed, DG_NEVER - 1);

        /* 2^64 - 1 units in 2^64 - 2 ns; the product fits 128 unsigned bits. */
        __extension__ unsigned __int128 travel = t - 1;

        travel = travel * UINT64_MAX / (DG_NEVER - 1);
        assert_true(dg_motion_angle(&m, t) == wrapped(INT64_MIN + (wide)travel));
    }
}

static void replay_floors_between_many_points(void **state)
{
    static struct dg_motion_point points[1000];
    uint64_t seed = 6;
    struct dg_motion m;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(points); i++) {
        points[i].at = i == 0 ? 7 : points[i - 1].at + random_up_to(&seed, DG_S(1));
        points[i].angle = (dg_angle)random_bits(&seed) / 2;
    }
    m = accepted((struct dg_motion){
        .kind = DG_MOTION_REPLAY, .points = points, .point_count = DG_COUNT(points)});
    for (size_t i = 0; i + 1 < DG_COUNT(points); i++) {
        const struct dg_motion_point *a = &points[i];
        const struct dg_motion_point *b = &points[i + 1];
        wide rise = (wide)b->angle - a->angle;

        for (int round = 0; round < 50; round++) {
            dg_ns t = random_bits(&seed) % (b->at - a->at + 1);

            assert_true(dg_motion_angle(&m, a->at + t) ==
                        a->angle + floor_div(rise * t, (wide)(b->at - a->at)));
        }
    }
}

/* Everything at its limit is taken over; a step beyond is refused and leaves the motion alone. */
static void check_refused(struct dg_motion wanted)
{
    struct dg_motion self;
    struct dg_motion before;

    memset(&self, 0xA5, sizeof self);
    memcpy(&before, &self, sizeof self);
    assert_int_equal(dg_motion_set(&self, &wanted), DG_ERR_ARGUMENT);
    assert_memory_equal(&self, &before, sizeof self);
}

static void speeds_out_of_range_are_refused(void **state)
{
    static const enum dg_motion_kind kinds[] = {DG_MOTION_SPEED, DG_MOTION_RAMP};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(kinds); i++) {
        struct dg_motion m = {.kind = kinds[i], .accel = 1, .mrpm = DG_MOTION_SPEED_MAX_MRPM};

        accepted(m);
        m.mrpm = -DG_MOTION_SPEED_MAX_MRPM;
        accepted(m);
        m.mrpm = DG_MOTION_SPEED_MAX_MRPM + 1;
        check_refused(m);
        m.mrpm = -DG_MOTION_SPEED_MAX_MRPM - 1;
        check_refused(m);
        m.mrpm = INT32_MIN;
        check_refused(m);
    }
}

static void ramps_and_sines_out_of_range_are_refused(void **state)
{
    struct dg_motion ramp = {.kind = DG_MOTION_RAMP, .mrpm = 1, .accel = 1};
    struct dg_motion sine = {.kind = DG_MOTION_SINE, .amplitude = AMPLITUDE_MAX, .period = 1};

    (void)state;
    accepted(ramp);
    ramp.accel = DG_MOTION_RAMP_MAX;
    accepted(ramp);
    ramp.accel = DG_MOTION_RAMP_MAX + 1;
    check_refused(ramp);
    ramp.accel = 0;
    check_refused(ramp);
    accepted(sine);
    sine.amplitude = -sine.amplitude;
    accepted(sine);
    sine.amplitude -= 1;
    check_refused(sine);
    sine.amplitude = AMPLITUDE_MAX + 1;
    check_refused(sine);
    sine.amplitude = INT64_MIN;
    check_refused(sine);
    sine.amplitude = 0;
    sine.period = DG_MOTION_PERIOD_MAX;
    accepted(sine);
    sine.period = DG_MOTION_PERIOD_MAX + 1;
    check_refused(sine);
    sine.period = 0;
    check_refused(sine);
}

static void replays_out_of_order_are_refused(void **state)
{
    struct dg_motion_point points[] = {{0, 5}, {1, 5}, {2, 5}};
    struct dg_motion m = {.kind = DG_MOTION_REPLAY, .points = points, .point_count = 3};

    (void)state;
    accepted(m);
    points[2].at = 1;
    check_refused(m);
    points[2].at = 0;
    check_refused(m);
    m.point_count = 2;
    accepted(m);
    points[0].at = 1;
    check_refused(m);
    m.point_count = 1;
    accepted(m);
    m.point_count = 0;
    check_refused(m);
    m.point_count = 1;
    m.points = NULL;
    check_refused(m);
}

static void kinds_that_are_none_are_refused(void **state)
{
    (void)state;
    check_refused((struct dg_motion){.kind = DG_MOTION_KIND_COUNT});
}

/* Fields that a kind does not use may hold anything. */
static void unused_fields_do_not_matter(void **state)
{
    struct dg_motion m = {.kind = DG_MOTION_STANDSTILL,
                          .from = 9,
                          .mrpm = INT32_MIN,
                          .amplitude = INT64_MIN,
                          .period = DG_NEVER};

    (void)state;
    m = accepted(m);
    assert_true(dg_motion_angle(&m, 5) == 9);
    m.mrpm = 60000;
    m.kind = DG_MOTION_SPEED;
    m = accepted(m);
    assert_true(dg_motion_angle(&m, DG_S(1)) == 9 + DG_TURN);
}

/* The same moment gives the same angle, in whatever order moments are asked for, and a copy too. */
static void angle_is_a_pure_function_of_time(void **state)
{
    static const struct dg_motion_point points[] = {{5, -5}, {DG_MS(1), 999}, {DG_MS(9), 3}};
    uint64_t seed = 7;

    (void)state;
    for (int kind = 0; kind < DG_MOTION_KIND_COUNT; kind++) {
        struct dg_motion m = accepted((struct dg_motion){.kind = (enum dg_motion_kind)kind,
                                                         .mrpm = 12345678,
                                                         .accel = DG_MS(2),
                                                         .hold = DG_MS(1),
                                                         .amplitude = DG_TURN,
                                                         .period = DG_MS(3),
                                                         .points = points,
                                                         .point_count = DG_COUNT(points)});
        struct dg_motion copy = m;

        for (int i = 0; i < 2000; i++) {
            dg_ns t = random_bits(&seed) % DG_MS(10);
            dg_angle angle = dg_motion_angle(&m, t);

            dg_motion_angle(&m, random_bits(&seed));
            assert_true(dg_motion_angle(&m, t) == angle);
            assert_true(dg_motion_angle(&copy, t) == angle);
        }
    }
}

/* At 2343.75 rpm a millisecond is a whole number of units, so that nothing is rounded. */
static void a_motion_plugs_into_a_world(void **state)
{
    struct dg_motion m =
        accepted((struct dg_motion){.kind = DG_MOTION_SPEED, .mrpm = -2343750, .from = 4});
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    world.angle = dg_motion_angle;
    world.angle_ctx = &m;
    assert_true(dg_world_angle(&world, DG_S(16)) == 4 - 625 * DG_TURN);
    assert_int_equal(dg_world_speed_mrpm(&world, HOURS_100), -2343750);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(standstill_stays),
        cmocka_unit_test(speed_starts_at_its_start),
        cmocka_unit_test(speed_is_exact_after_100_hours),
        cmocka_unit_test(speed_is_the_exact_floor),
        cmocka_unit_test(ramp_by_hand),
        cmocka_unit_test(ramps_of_hours_are_exact),
        cmocka_unit_test(ramp_is_exact),
        cmocka_unit_test(ramp_survives_any_hold),
        cmocka_unit_test(ramp_is_monotonic_and_continuous),
        cmocka_unit_test(ramp_is_continuous_at_the_joints),
        cmocka_unit_test(sine_by_hand),
        cmocka_unit_test(sine_is_within_its_error),
        cmocka_unit_test(sine_wraps_with_the_angle),
        cmocka_unit_test(replay_by_hand),
        cmocka_unit_test(replay_of_one_point),
        cmocka_unit_test(replay_spans_both_types),
        cmocka_unit_test(replay_floors_between_many_points),
        cmocka_unit_test(speeds_out_of_range_are_refused),
        cmocka_unit_test(ramps_and_sines_out_of_range_are_refused),
        cmocka_unit_test(replays_out_of_order_are_refused),
        cmocka_unit_test(kinds_that_are_none_are_refused),
        cmocka_unit_test(unused_fields_do_not_matter),
        cmocka_unit_test(angle_is_a_pure_function_of_time),
        cmocka_unit_test(a_motion_plugs_into_a_world),
    };

    return cmocka_run_group_tests_name("motion", tests, NULL, NULL);
}
