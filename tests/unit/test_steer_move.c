/* SPDX-License-Identifier: MIT */
/* Moves against a model in long double, and against what must hold for every move. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/shaft.h"
#include "effort.h"
#include "motion_model.h"

#define SPEED_MAX DG_MOTION_SPEED_MAX_MRPM
#define START DG_S(1000)
/** 0.001 rpm in units of 2^-32 turn per nanosecond, and 0.001 rpm/s per square nanosecond. */
#define PER_NS (262144.0L / 3662109375.0L)
#define PER_NS2 (PER_NS / 1e9L)
#define REV_PER_S 60000

/** A move from a present speed; the angle there is `from`. */
struct move {
    dg_angle from;
    dg_angle target;
    int32_t mrpm; /**< present speed */
    int32_t limit;
    int64_t accel;
};

static int64_t random_signed(uint64_t *seed, uint64_t limit)
{
    int64_t value = (int64_t)random_up_to(seed, limit);

    return (random_bits(seed) & 1) != 0 ? value : -value;
}

static struct move random_move(uint64_t *seed, uint64_t way)
{
    struct move move = {
        .from = random_signed(seed, way / 2),
        .target = random_signed(seed, way / 2),
        .mrpm = (int32_t)random_signed(seed, SPEED_MAX),
        .limit = (int32_t)random_up_to(seed, SPEED_MAX),
        .accel = (int64_t)random_up_to(seed, DG_SHAFT_ACCELERATION_MAX),
    };

    move.mrpm = random_bits(seed) % 4 == 0 ? 0 : move.mrpm;
    return move;
}

static struct dg_shaft moving(const struct move *move)
{
    struct dg_shaft shaft;

    dg_shaft_init(&shaft);
    (void)dg_shaft_set_position(&shaft, START, move->from);
    (void)dg_shaft_set_velocity(&shaft, START, move->mrpm);
    assert_int_equal(dg_shaft_set_acceleration(&shaft, move->accel), DG_OK);
    assert_int_equal(dg_shaft_move(&shaft, START, move->target, move->limit), DG_OK);
    assert_true(dg_shaft_angle(&shaft, START) == move->from);
    return shaft;
}

/** The profile of a move in the direction of its end: units and nanoseconds. */
struct model {
    long double sign, speed, top, accel;
    long double change, hold, brake; /**< how long each takes */
    long double scale;               /**< the longest way in it */
};

static struct model model_of(const struct move *move)
{
    long double speed = move->mrpm * PER_NS;
    long double limit = move->limit * PER_NS;
    long double way = (long double)move->target - (long double)move->from;
    struct model model = {.sign = 1, .accel = (long double)move->accel * PER_NS2};
    long double a = model.accel;
    long double stop = speed * fabsl(speed) / (2 * a);

    if (way < stop) {
        model.sign = -1;
    }
    speed *= model.sign;
    way *= model.sign;
    model.speed = speed;
    model.top = fminl(limit, sqrtl(fmaxl(0, a * way + speed * speed / 2)));
    if (speed > limit) {
        model.top = limit;
    }
    model.change = fabsl(model.top - speed) / a;
    model.brake = model.top / a;
    long double left = way - (speed + model.top) / 2 * model.change - model.top * model.brake / 2;
    model.hold = model.top > 0 ? fmaxl(0, left) / model.top : 0;
    model.scale = fabsl(way) + fabsl(stop) + model.top * model.brake;
    return model;
}

/** How far the model is from its beginning after `t`. */
static long double model_way(const struct model *m, long double t)
{
    long double up = m->top < m->speed ? -m->accel : m->accel;
    long double change = fminl(t, m->change);
    long double hold = fminl(fmaxl(0, t - m->change), m->hold);
    long double brake = fminl(fmaxl(0, t - m->change - m->hold), m->brake);

    return m->sign * (m->speed * change + up * change * change / 2 + m->top * hold +
                      m->top * brake - m->accel * brake * brake / 2);
}

/* A nanosecond at the lowest acceleration is the unit of the planning: 1 / accel ns of travel. */
static void check_against_model(const struct move *move, uint64_t *seed)
{
    struct dg_shaft shaft = moving(move);
    const struct model model = model_of(move);
    const long double length = model.change + model.hold + model.brake;
    const long double took = (long double)(dg_shaft_settled(&shaft) - START);
    const long double tolerance = 2 + model.scale * 0x1p-58L + model.top / (long double)move->accel;

    if (dg_shaft_settled(&shaft) == DG_NEVER) {
        assert_true(length > (long double)(DG_NEVER - START) * (1 - 1e-9L));
        return;
    }
    assert_true(fabsl(took - length) <= 3 + length * 1e-15L);
    for (int i = 0; i < 20; i++) {
        dg_ns t = random_bits(seed) % (uint64_t)(took + 10);
        const long double way = model_way(&model, (long double)t);
        /* Modulo 2^64, as the angle wraps. */
        const uint64_t wanted = (uint64_t)move->from + (uint64_t)(wide)floorl(way);
        const int64_t off = (int64_t)((uint64_t)dg_shaft_angle(&shaft, START + t) - wanted);

        assert_true((long double)off <= tolerance && (long double)off >= -tolerance);
    }
}

static void moves_follow_the_model(void **state)
{
    const uint32_t rounds = effort(4000, 20000);
    uint64_t seed = 1;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        struct move move = random_move(&seed, (uint64_t)1 << 44);

        move.accel = (int64_t)random_up_to(&seed, DG_SHAFT_ACCELERATION_MAX / 1000) * 1000;
        check_against_model(&move, &seed);
    }
}

static wide magnitude(wide value)
{
    return value < 0 ? -value : value;
}

/** The furthest a move may be from one nanosecond to the next, in units. */
static wide largest_step(const struct move *move)
{
    wide mrpm = magnitude(move->mrpm) > move->limit ? magnitude(move->mrpm) : move->limit;

    return mrpm * 262144 / 3662109375 + 1;
}

/** Nanoseconds to both sides of a joint of two phases. */
static void check_joint(struct dg_shaft *shaft, const struct move *move, dg_ns joint)
{
    const dg_ns first = joint > START + 10 ? joint - 10 : START;
    const wide largest = largest_step(move);
    /* The speed changes by accel prpm in a nanosecond; 1 unit for each of three floors. */
    const wide bend = (wide)move->accel * 512 / (wide)DG_SHAFT_PARTS + 3 + largest / move->accel;
    dg_angle angle = dg_shaft_angle(shaft, first);
    int32_t mrpm = dg_shaft_mrpm(shaft, first);
    wide before = 0;

    for (dg_ns t = first + 1; t < joint + 10 && joint < DG_NEVER - 10; t++) {
        const dg_angle next = dg_shaft_angle(shaft, t);
        const int32_t next_mrpm = dg_shaft_mrpm(shaft, t);
        const wide step = (int64_t)((uint64_t)next - (uint64_t)angle);

        assert_true(magnitude(step) <= largest);
        assert_true(t == first + 1 || magnitude(step - before) <= bend);
        assert_true(magnitude(next_mrpm) <= magnitude(move->mrpm) || next_mrpm <= move->limit);
        assert_true(magnitude(next_mrpm) <= magnitude(move->mrpm) || -next_mrpm <= move->limit);
        assert_true(magnitude((wide)next_mrpm - mrpm) <= move->accel / 1000000000 + 1);
        angle = next;
        mrpm = next_mrpm;
        before = step;
    }
}

/** Inside a phase there is its acceleration and nothing else: of three moments at equal distances
 * the floors make up to 3 units. */
static void check_phase(struct dg_shaft *shaft, const struct dg_shaft_phase *phase, dg_ns end,
                        uint64_t *seed)
{
    const dg_ns h = random_up_to(seed, (end - phase->at) / 2 + 1) % ((uint64_t)1 << 38);

    if (2 * h >= end - phase->at) {
        return;
    }
    const dg_ns t = phase->at + random_bits(seed) % (end - phase->at - 2 * h);
    const uint64_t a = (uint64_t)dg_shaft_angle(shaft, t);
    const uint64_t b = (uint64_t)dg_shaft_angle(shaft, t + h);
    const uint64_t c = (uint64_t)dg_shaft_angle(shaft, t + 2 * h);
    const wide bent = (int64_t)(c - b - b + a);

    assert_true(magnitude(bent - (wide)phase->mrpm_per_s * (wide)h * (wide)h * 512 /
                                     (wide)DG_SHAFT_PARTS) <= 3);
}

/** Modulo 2^64, as the angle wraps. */
static bool still_before(const struct move *move, dg_angle angle, bool backwards)
{
    const int64_t left = (int64_t)((uint64_t)move->target - (uint64_t)angle);

    return backwards ? left <= 0 : left >= 0;
}

static void check_properties(const struct move *move, uint64_t *seed)
{
    struct dg_shaft shaft = moving(move);
    const dg_ns end = dg_shaft_settled(&shaft);
    const struct dg_shaft_course *course = &shaft.course;

    assert_in_range(course->count, 1, DG_SHAFT_PHASES);
    for (size_t i = 0; i < course->count; i++) {
        check_joint(&shaft, move, course->phase[i].at);
        if (i + 1 < course->count) {
            assert_true(course->phase[i].at <= course->phase[i + 1].at);
            check_phase(&shaft, &course->phase[i], course->phase[i + 1].at, seed);
        }
    }
    if (end == DG_NEVER) {
        return;
    }
    assert_true(dg_shaft_angle(&shaft, end) == move->target);
    assert_true(dg_shaft_angle(&shaft, DG_NEVER) == move->target);
    assert_int_equal(dg_shaft_mrpm(&shaft, end), 0);
    /* The last phase but one brakes, or holds when there is no acceleration: never too far. */
    if (course->count > 1 && end > START) {
        const struct dg_shaft_phase *last = &course->phase[course->count - 2];

        for (dg_ns t = last->at > end - 20 && last->at < end ? last->at : end - 1; t < end; t++) {
            assert_true(t < START || last->at >= end ||
                        still_before(move, dg_shaft_angle(&shaft, t), last->prpm < 0));
        }
    }
}

static void moves_keep_their_promises(void **state)
{
    static const uint64_t ways[] = {4, 1000, (uint64_t)1 << 20, (uint64_t)1 << 32,
                                    (uint64_t)1 << 44};
    const uint32_t rounds = effort(4000, 20000);
    uint64_t seed = 2;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        const struct move move = random_move(&seed, ways[i % DG_COUNT(ways)]);

        check_properties(&move, &seed);
    }
}

/* From one end of the type to the other, at the lowest and highest figures. */
static void extreme_moves(void **state)
{
    static const dg_angle angles[] = {INT64_MIN, INT64_MIN + 1, -1, 0, 1, INT64_MAX};
    static const int32_t speeds[] = {0, 1, -1, SPEED_MAX, -SPEED_MAX};
    static const int32_t limits[] = {1, 1000, SPEED_MAX};
    static const int64_t accels[] = {1, 2, 1000000, DG_SHAFT_ACCELERATION_MAX};
    uint64_t seed = 3;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(angles) * DG_COUNT(angles) * DG_COUNT(speeds); i++) {
        for (size_t j = 0; j < DG_COUNT(limits) * DG_COUNT(accels); j++) {
            check_properties(
                &(struct move){
                    .from = angles[i % DG_COUNT(angles)],
                    .target = angles[i / DG_COUNT(angles) % DG_COUNT(angles)],
                    .mrpm = speeds[i / DG_COUNT(angles) / DG_COUNT(angles)],
                    .limit = limits[j % DG_COUNT(limits)],
                    .accel = accels[j / DG_COUNT(limits)],
                },
                &seed);
        }
    }
}

/** What a shaft does at a moment after START. */
struct row {
    dg_ns at;
    dg_angle angle;
    int32_t mrpm;
};

static void check_rows(const struct move *move, const struct row *rows, size_t count)
{
    /* Everything the other way round, too. */
    struct move mirrored = *move;

    mirrored.from = -move->from;
    mirrored.target = -move->target;
    mirrored.mrpm = -move->mrpm;
    struct dg_shaft shaft = moving(move);
    struct dg_shaft mirror = moving(&mirrored);

    for (size_t i = 0; i < count; i++) {
        assert_true(dg_shaft_angle(&shaft, START + rows[i].at) == rows[i].angle);
        assert_int_equal(dg_shaft_mrpm(&shaft, START + rows[i].at), rows[i].mrpm);
        assert_true(dg_shaft_angle(&mirror, START + rows[i].at) == -rows[i].angle);
        assert_int_equal(dg_shaft_mrpm(&mirror, START + rows[i].at), -rows[i].mrpm);
    }
    assert_true(dg_shaft_settled(&shaft) == START + rows[count - 1].at);
    assert_true(dg_shaft_settled(&mirror) == START + rows[count - 1].at);
}

/* 1 rev/s in a second, over half a turn; all figures come out even. */
static void trapezoid(void **state)
{
    static const struct move move = {0, 3 * DG_TURN, 0, REV_PER_S, REV_PER_S};
    static const struct row rows[] = {
        {0, 0, 0},
        {DG_MS(500), DG_TURN / 8, REV_PER_S / 2},
        {DG_S(1), DG_TURN / 2, REV_PER_S},
        {DG_S(3), DG_TURN * 5 / 2, REV_PER_S},
        {DG_MS(3500), DG_TURN * 23 / 8, REV_PER_S / 2},
        {DG_S(4), DG_TURN * 3, 0},
    };

    (void)state;
    check_rows(&move, rows, DG_COUNT(rows));
}

static void triangle(void **state)
{
    static const struct move move = {0, DG_TURN, 0, 2 * REV_PER_S, REV_PER_S};
    static const struct row rows[] = {
        {0, 0, 0},
        {DG_S(1), DG_TURN / 2, REV_PER_S},
        {DG_S(2), DG_TURN, 0},
    };

    (void)state;
    check_rows(&move, rows, DG_COUNT(rows));
}

/* Moving away at 1 rev/s: stands at -1/2, and from there as from rest. */
static void moving_away(void **state)
{
    static const struct move move = {0, DG_TURN / 2, -REV_PER_S, REV_PER_S, REV_PER_S};
    static const struct row rows[] = {
        {0, 0, -REV_PER_S},
        {DG_S(1), -DG_TURN / 2, 0},
        {DG_S(2), 0, REV_PER_S},
        {DG_S(3), DG_TURN / 2, 0},
    };

    (void)state;
    check_rows(&move, rows, DG_COUNT(rows));
}

/* Too fast to stop: at 2 rev/s it stands after 2 turns, and comes back half a turn and more. */
static void overshoot(void **state)
{
    static const struct move move = {0, DG_TURN, 2 * REV_PER_S, 5 * REV_PER_S, REV_PER_S};
    static const struct row rows[] = {
        {0, 0, 2 * REV_PER_S},     {DG_S(1), DG_TURN * 3 / 2, REV_PER_S},
        {DG_S(2), DG_TURN * 2, 0}, {DG_S(3), DG_TURN * 3 / 2, -REV_PER_S},
        {DG_S(4), DG_TURN, 0},
    };

    (void)state;
    check_rows(&move, rows, DG_COUNT(rows));
}

/* Faster than it may go: down to the limit first. */
static void above_the_limit(void **state)
{
    static const struct move move = {0, 5 * DG_TURN, 3 * REV_PER_S, REV_PER_S, REV_PER_S};
    static const struct row rows[] = {
        {0, 0, 3 * REV_PER_S},
        {DG_S(1), DG_TURN * 5 / 2, 2 * REV_PER_S},
        {DG_S(2), DG_TURN * 4, REV_PER_S},
        {DG_MS(2500), DG_TURN * 9 / 2, REV_PER_S},
        {DG_MS(3500), DG_TURN * 5, 0},
    };

    (void)state;
    check_rows(&move, rows, DG_COUNT(rows));
}

/* Just enough room to brake: nothing but that. */
static void just_in_time(void **state)
{
    static const struct move move = {0, DG_TURN / 2, REV_PER_S, REV_PER_S, REV_PER_S};
    static const struct row rows[] = {
        {0, 0, REV_PER_S},
        {DG_MS(500), DG_TURN * 3 / 8, REV_PER_S / 2},
        {DG_S(1), DG_TURN / 2, 0},
    };

    (void)state;
    check_rows(&move, rows, DG_COUNT(rows));
}

static void at_once(void **state)
{
    static const struct move move = {7, 7 + 2 * DG_TURN, -REV_PER_S, REV_PER_S, 0};
    static const struct row rows[] = {
        {0, 7, REV_PER_S},
        {DG_S(1), 7 + DG_TURN, REV_PER_S},
        {DG_S(2), 7 + 2 * DG_TURN, 0},
    };

    (void)state;
    check_rows(&move, rows, DG_COUNT(rows));
}

static void nowhere_to_go(void **state)
{
    static const int64_t accels[] = {0, 1, REV_PER_S, DG_SHAFT_ACCELERATION_MAX};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(accels); i++) {
        const struct move move = {5, 5, 0, REV_PER_S, accels[i]};
        struct dg_shaft shaft = moving(&move);

        assert_true(dg_shaft_settled(&shaft) == START);
        assert_true(dg_shaft_angle(&shaft, START + 1) == 5);
    }
}

/* Less than a unit to go, at the lowest acceleration: no speed is worth reaching. */
static void less_than_a_unit_to_go(void **state)
{
    struct dg_shaft shaft;

    (void)state;
    dg_shaft_init(&shaft);
    (void)dg_shaft_set_velocity(&shaft, 0, 1);
    (void)dg_shaft_set_velocity(&shaft, 1, 0);
    assert_true(shaft.course.phase[0].from == 0 && shaft.course.phase[0].part > 0);
    (void)dg_shaft_set_acceleration(&shaft, 1);
    assert_int_equal(dg_shaft_move(&shaft, 2, 0, 1), DG_OK);
    assert_true(dg_shaft_angle(&shaft, dg_shaft_settled(&shaft)) == 0);
    assert_true(shaft.course.phase[shaft.course.count - 1u].part == 0);
    shaft.course.phase[0] = (struct dg_shaft_phase){.at = 0, .part = 1};
    shaft.course.count = 1;
    assert_int_equal(dg_shaft_move(&shaft, 3, 0, 1), DG_OK);
    assert_true(dg_shaft_settled(&shaft) == 3);
    assert_true(shaft.course.phase[0].part == 0);
}

/* At once: never faster than wanted, never beyond the target, there within a nanosecond. */
static void at_once_lands_in_time(void **state)
{
    const uint32_t rounds = effort(4000, 20000);
    uint64_t seed = 4;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        struct move move = random_move(&seed, (uint64_t)1 << 60);

        move.accel = 0;
        struct dg_shaft shaft = moving(&move);
        const wide way = magnitude((wide)move.target - move.from);
        const wide time = (way * 3662109375 + (wide)move.limit * 262144 - 1) / move.limit / 262144;
        const dg_ns end = dg_shaft_settled(&shaft);

        if (time >= (wide)(DG_NEVER - START)) {
            assert_true(end == DG_NEVER);
            continue;
        }
        assert_true(end == START + (dg_ns)time);
        assert_true(dg_shaft_angle(&shaft, end) == move.target);
        if (end > START) {
            const wide left = magnitude((wide)dg_shaft_angle(&shaft, end - 1) - (wide)move.target);

            assert_true(left <= (wide)move.limit * 262144 / 3662109375 + 1);
            assert_true(
                still_before(&move, dg_shaft_angle(&shaft, end - 1), move.target < move.from));
        }
    }
}

/* Commands in the middle of whatever goes on: angle and speed go on from where they are. */
static void commands_are_continuous(void **state)
{
    struct dg_shaft shaft;
    const uint32_t rounds = effort(4000, 20000);
    uint64_t seed = 5;
    dg_ns now = 0;

    (void)state;
    dg_shaft_init(&shaft);
    for (uint32_t i = 0; i < rounds; i++) {
        const int64_t accel = (int64_t)random_up_to(&seed, DG_SHAFT_ACCELERATION_MAX);
        const struct dg_shaft as_before = shaft;
        struct dg_shaft was = as_before;

        now += random_up_to(&seed, DG_S(10));
        assert_int_equal(dg_shaft_set_acceleration(&shaft, accel), DG_OK);
        if (i % 3 == 0) {
            (void)dg_shaft_set_velocity(&shaft, now, (int32_t)random_signed(&seed, SPEED_MAX));
        } else {
            (void)dg_shaft_move(&shaft, now, random_signed(&seed, (uint64_t)1 << 45),
                                (int32_t)random_up_to(&seed, SPEED_MAX));
        }
        /* A move that ends at once jumps by less than a unit. */
        const int64_t jump =
            (int64_t)((uint64_t)dg_shaft_angle(&shaft, now) - (uint64_t)dg_shaft_angle(&was, now));

        assert_in_range(jump + 1, 0, 2);
        assert_in_range(dg_shaft_mrpm(&shaft, now) - dg_shaft_mrpm(&was, now) + 1, 0, 2);
        for (dg_ns back = 1; back < DG_MS(2) && back <= now; back *= 10) {
            assert_true(now - back < was.course.at ||
                        dg_shaft_angle(&shaft, now - back) == dg_shaft_angle(&was, now - back));
        }
    }
}

/* Move after move: each begins where the one before ended, and nothing is left of that one. */
static void no_drift_over_many_moves(void **state)
{
    struct dg_shaft shaft;
    uint64_t seed = 6;
    dg_ns now = 0;

    (void)state;
    dg_shaft_init(&shaft);
    for (int i = 0; i < 10000; i++) {
        const dg_angle target = random_signed(&seed, (uint64_t)1 << 36);

        (void)dg_shaft_set_acceleration(&shaft, (int64_t)random_up_to(&seed, 100000000));
        (void)dg_shaft_move(&shaft, now, target, (int32_t)random_up_to(&seed, 10000000));
        assert_true(dg_shaft_settled(&shaft) < DG_NEVER);
        now = dg_shaft_settled(&shaft);
        if (now > DG_NEVER / 2) {
            now = 0;
            dg_shaft_init(&shaft);
            continue;
        }
        assert_true(dg_shaft_angle(&shaft, now) == target);
        assert_true(shaft.course.phase[shaft.course.count - 1u].part == 0);
    }
}

/* What still turns is not there yet. The speeds are one more than a multiple of what a nanosecond
   takes off: in the last one the shaft has 10^-12 rpm, and a part of a unit to go. */
static void not_there_before_its_end(void **state)
{
    static const struct {
        int64_t accel;
        int32_t limit;
    } rows[] = {{3, 1}, {7, 6}, {9, 1}, {11, 10}, {13, 12}, {999999, 1000}, {999999999, 1}};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct move move = {0, DG_TURN, 0, rows[i].limit, rows[i].accel};
        struct dg_shaft shaft = moving(&move);
        const dg_ns end = dg_shaft_settled(&shaft);
        assert_true(rows[i].limit * INT64_C(1000000000) % rows[i].accel == 1);
        assert_true(dg_shaft_angle(&shaft, end) == DG_TURN);
        assert_true(dg_shaft_angle(&shaft, end - 1u) == DG_TURN - 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moves_follow_the_model),
        cmocka_unit_test(moves_keep_their_promises),
        cmocka_unit_test(extreme_moves),
        cmocka_unit_test(trapezoid),
        cmocka_unit_test(triangle),
        cmocka_unit_test(moving_away),
        cmocka_unit_test(overshoot),
        cmocka_unit_test(above_the_limit),
        cmocka_unit_test(just_in_time),
        cmocka_unit_test(at_once),
        cmocka_unit_test(nowhere_to_go),
        cmocka_unit_test(less_than_a_unit_to_go),
        cmocka_unit_test(at_once_lands_in_time),
        cmocka_unit_test(commands_are_continuous),
        cmocka_unit_test(no_drift_over_many_moves),
        cmocka_unit_test(not_there_before_its_end),
    };

    return cmocka_run_group_tests_name("steer-move", tests, NULL, NULL);
}
