/* SPDX-License-Identifier: MIT */
/* Commands by hand, gears, what is refused. Moves against a model are in test_steer_move.c. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/shaft.h"
#include "drehgeber/world.h"
#include "motion_model.h"

#define SPEED_MAX DG_MOTION_SPEED_MAX_MRPM
/** 1 rev/s, and 1 rev/s in a second. */
#define REV_PER_S 60000
#define REV_PER_S2 60000

static struct dg_shaft fresh(int64_t mrpm_per_s)
{
    struct dg_shaft shaft;

    dg_shaft_init(&shaft);
    assert_int_equal(dg_shaft_set_acceleration(&shaft, mrpm_per_s), DG_OK);
    return shaft;
}

/** What a shaft does at a moment. */
struct row {
    dg_ns at;
    dg_angle angle;
    int32_t mrpm;
};

static void check_rows(struct dg_shaft *shaft, const struct row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        assert_true(dg_shaft_angle(shaft, rows[i].at) == rows[i].angle);
        assert_int_equal(dg_shaft_mrpm(shaft, rows[i].at), rows[i].mrpm);
    }
}

static void a_new_shaft_rests(void **state)
{
    static const struct row rows[] = {{0, 0, 0}, {1, 0, 0}, {DG_NEVER, 0, 0}};
    struct dg_shaft shaft = fresh(0);

    (void)state;
    check_rows(&shaft, rows, DG_COUNT(rows));
    assert_true(dg_shaft_settled(&shaft) == 0);
}

static void without_acceleration_all_is_at_once(void **state)
{
    static const struct row rows[] = {
        {DG_S(1) - 1, 0, 0},
        {DG_S(1), 5, 0},
        {DG_S(2), 5, REV_PER_S},
        {DG_S(4), 5 + 2 * DG_TURN, -REV_PER_S},
        {DG_S(7), 5 - DG_TURN, -REV_PER_S},
    };
    static const struct row end[] = {
        {DG_S(8) - 1, 5 - 2 * DG_TURN + 4, -REV_PER_S},
        {DG_S(8), 5 - 2 * DG_TURN, 0},
        {DG_NEVER, 5 - 2 * DG_TURN, 0},
    };
    struct dg_shaft shaft = fresh(0);

    (void)state;
    assert_int_equal(dg_shaft_set_position(&shaft, DG_S(1), 5), DG_OK);
    check_rows(&shaft, rows, 2);
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(2), REV_PER_S), DG_OK);
    check_rows(&shaft, rows + 2, 1);
    assert_true(dg_shaft_settled(&shaft) == DG_S(2));
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(4), -REV_PER_S), DG_OK);
    check_rows(&shaft, rows + 2, 3);
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(8), 0), DG_OK);
    check_rows(&shaft, end, DG_COUNT(end));
}

/* 1 rev/s^2: up to 1 rev/s in a second over half a turn; from there to -1 rev/s in two. */
static void speed_changes_by_hand(void **state)
{
    static const struct row up[] = {
        {DG_S(1), 0, 0},
        {DG_MS(1500), DG_TURN / 8, REV_PER_S / 2},
        {DG_S(2), DG_TURN / 2, REV_PER_S},
        {DG_S(4), DG_TURN * 5 / 2, REV_PER_S},
    };
    static const struct row back[] = {
        {DG_S(3), DG_TURN * 3 / 2, REV_PER_S},
        {DG_S(4), DG_TURN * 5 / 2, REV_PER_S},
        {DG_S(5), DG_TURN * 3, 0},
        {DG_S(6), DG_TURN * 5 / 2, -REV_PER_S},
        {DG_S(7), DG_TURN * 3 / 2, -REV_PER_S},
    };
    struct dg_shaft shaft = fresh(REV_PER_S2);

    (void)state;
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(1), REV_PER_S), DG_OK);
    check_rows(&shaft, up, DG_COUNT(up));
    assert_true(dg_shaft_settled(&shaft) == DG_S(2));
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(4), -REV_PER_S), DG_OK);
    check_rows(&shaft, back, DG_COUNT(back));
    assert_true(dg_shaft_settled(&shaft) == DG_S(6));
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(7), 0), DG_OK);
    assert_true(dg_shaft_settled(&shaft) == DG_S(8));
    assert_true(dg_shaft_angle(&shaft, DG_NEVER) == DG_TURN);
}

/* The same speed again is no change, whatever the acceleration. */
static void the_same_speed_again_changes_nothing(void **state)
{
    struct dg_shaft shaft = fresh(REV_PER_S2);

    (void)state;
    (void)dg_shaft_set_velocity(&shaft, 0, REV_PER_S);
    (void)dg_shaft_set_velocity(&shaft, DG_S(3), REV_PER_S);
    assert_true(dg_shaft_settled(&shaft) == DG_S(3));
    assert_int_equal(shaft.course.count, 1);
    assert_true(dg_shaft_angle(&shaft, DG_S(4)) == DG_TURN * 7 / 2);
}

/* Moments before a command are answered as they were, those before the one before at its speed. */
static void looking_back(void **state)
{
    struct dg_shaft shaft = fresh(0);

    (void)state;
    (void)dg_shaft_set_velocity(&shaft, DG_S(1), REV_PER_S);
    (void)dg_shaft_set_velocity(&shaft, DG_S(2), -REV_PER_S);
    assert_true(dg_shaft_angle(&shaft, DG_MS(1500)) == DG_TURN / 2);
    assert_int_equal(dg_shaft_mrpm(&shaft, DG_MS(1500)), REV_PER_S);
    assert_true(dg_shaft_angle(&shaft, DG_MS(500)) == -DG_TURN / 2);
    /* A course that was replaced at its own moment was never there; time does not run backwards. */
    (void)dg_shaft_set_position(&shaft, DG_S(2), 77);
    (void)dg_shaft_set_position(&shaft, DG_S(1), 78);
    assert_true(dg_shaft_angle(&shaft, DG_MS(1500)) == DG_TURN / 2);
    assert_true(dg_shaft_angle(&shaft, DG_S(2)) == 78);
    (void)dg_shaft_set_position(&shaft, DG_S(3), 79);
    assert_true(dg_shaft_angle(&shaft, DG_MS(1500)) == 78);
}

/* What an encoder measures at 10 000 commands a second is the speed that is commanded. */
static void encoders_see_the_speed_between_commands(void **state)
{
    struct dg_shaft shaft = fresh(0);
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    world.angle = dg_shaft_angle;
    world.angle_ctx = &shaft;
    for (dg_ns now = 0; now < DG_MS(10); now += DG_US(100)) {
        (void)dg_shaft_set_velocity(&shaft, now, 3000000);
        if (now >= DG_MS(1)) {
            assert_in_range(dg_world_speed_mrpm(&world, now), 2999999, 3000001);
        }
    }
}

/* A speed commanded again and again is as exact as one commanded once. */
/* At an angle and a speed from elsewhere, whatever the acceleration. */
static void turning_on_at_once(void **state)
{
    const int64_t rev_per_s = INT64_C(60000000000000);
    const int64_t most = INT64_C(1000000000) * SPEED_MAX;
    static const struct row rows[] = {
        {DG_S(1), 100, REV_PER_S},
        {DG_S(3) - 1, 100 + 2 * DG_TURN - 5, REV_PER_S},
        {DG_S(3), 100 + 2 * DG_TURN, -REV_PER_S / 2},
        {DG_S(5), 100 + DG_TURN, -REV_PER_S / 2},
    };
    struct dg_shaft driver = fresh(0);
    struct dg_shaft shaft = fresh(REV_PER_S2);

    (void)state;
    assert_int_equal(dg_shaft_turn(&shaft, DG_S(1), 100, rev_per_s), DG_OK);
    check_rows(&shaft, rows, 1);
    assert_int_equal(dg_shaft_turn(&shaft, DG_S(3), 100 + 2 * DG_TURN, -rev_per_s / 2), DG_OK);
    check_rows(&shaft, rows + 1, DG_COUNT(rows) - 1);
    assert_int_equal(dg_shaft_turn(&shaft, DG_S(6), 0, most), DG_OK);
    assert_int_equal(dg_shaft_mrpm(&shaft, DG_S(6)), SPEED_MAX);
    assert_int_equal(dg_shaft_turn(&shaft, DG_S(6), 0, most + 1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_turn(&shaft, DG_S(6), 0, -most - 1), DG_ERR_ARGUMENT);
    (void)dg_shaft_couple(&shaft, &driver, 1, 1);
    assert_int_equal(dg_shaft_turn(&shaft, DG_S(6), 0, 0), DG_ERR_ARGUMENT);
}

static void no_drift_at_a_constant_speed(void **state)
{
    uint64_t seed = 1;

    (void)state;
    for (int round = 0; round < 20; round++) {
        struct dg_shaft shaft = fresh(round % 2 == 0 ? 0 : 1 + round);
        int32_t mrpm = random_mrpm(&seed);
        dg_ns now = 0;

        (void)dg_shaft_set_velocity(&shaft, 0, mrpm);
        (void)dg_shaft_set_acceleration(&shaft, 0);
        (void)dg_shaft_set_velocity(&shaft, 0, mrpm);
        for (int i = 0; i < 2000; i++) {
            now += random_up_to(&seed, DG_S(1000));
            (void)dg_shaft_set_velocity(&shaft, now, mrpm);
            assert_true(dg_shaft_angle(&shaft, now) ==
                        wrapped(floor_div((wide)mrpm * now * 262144, 3662109375)));
        }
    }
}

/** The exact place in 1 / DG_SHAFT_PARTS, kept beside a shaft. */
struct ledger {
    wide parts;
    int64_t prpm;
};

/** Travel `time` from the present speed with `accel`, exactly. */
static void enter(struct ledger *self, wide time, int64_t accel)
{
    self->parts += 256 * time * (2 * (wide)self->prpm + accel * time);
    self->prpm += (int64_t)(accel * time);
}

/* Random speed changes, most of them interrupted by the next one: exact to the last unit. */
static void no_drift_over_many_speed_changes(void **state)
{
    static struct ledger ledger;
    uint64_t seed = 3;
    dg_ns now = 0;
    struct dg_shaft shaft = fresh(0);
    unsigned reached = 0;

    (void)state;
    for (int i = 0; i < 30000; i++) {
        int64_t accel = (int64_t)random_up_to(&seed, DG_SHAFT_ACCELERATION_MAX);
        int32_t mrpm = random_mrpm(&seed);
        dg_ns span = random_up_to(&seed, DG_S(1));
        wide change = (wide)mrpm * 1000000000 - ledger.prpm;
        wide time = (change < 0 ? -change : change) / accel;
        wide rest = (change < 0 ? -change : change) % accel;

        assert_int_equal(dg_shaft_set_acceleration(&shaft, accel), DG_OK);
        assert_int_equal(dg_shaft_set_velocity(&shaft, now, mrpm), DG_OK);
        now += span;
        if ((wide)span <= time) {
            enter(&ledger, (wide)span, change < 0 ? -accel : accel);
        } else {
            /* The rest of the change takes rest / accel ns: (v + w) * rest / accel halves. */
            enter(&ledger, time, change < 0 ? -accel : accel);
            ledger.parts += 256 * (ledger.prpm + (wide)mrpm * 1000000000) * rest / accel;
            ledger.prpm = (int64_t)mrpm * 1000000000;
            ledger.parts += 512 * (wide)ledger.prpm * ((wide)span - time) -
                            512 * (wide)ledger.prpm * rest / accel;
            reached++;
        }
        wide angle = floor_div(ledger.parts, (wide)DG_SHAFT_PARTS);
        wide off = (wide)(int64_t)((uint64_t)dg_shaft_angle(&shaft, now) - (uint64_t)angle);

        assert_true(off >= -1 && off <= 1);
        assert_int_equal(dg_shaft_mrpm(&shaft, now), ledger.prpm / 1000000000);
    }
    assert_in_range(reached, 3000, 27000);
}

/* Braking begins speed^2 / (2 * acceleration) before the target, within 4 * 10^-14 unit: of
 * DG_SHAFT_PARTS that is less than 2 * 256, and 256 are half a 10^-12 rpm for a nanosecond. */
static void braking_ends_at_the_target(void **state)
{
    uint64_t seed = 7;
    unsigned braked = 0;

    (void)state;
    for (int i = 0; i < 2000; i++) {
        const int64_t accel = DG_SHAFT_ACCELERATION_MAX - (int64_t)random_up_to(&seed, 1u << 30);
        const dg_angle target = (dg_angle)random_up_to(&seed, UINT64_C(1) << 40);
        struct dg_shaft shaft = fresh(accel);

        (void)dg_shaft_move(&shaft, 0, i % 2 == 0 ? target : -target, SPEED_MAX);
        const struct dg_shaft_phase *brake = &shaft.course.phase[shaft.course.count - 2u];
        if (brake->mrpm_per_s == 0 || brake->prpm == 0) {
            continue;
        }
        const wide way = 256 * ((wide)brake->prpm * brake->prpm / accel);
        const wide end = (wide)brake->from * (wide)DG_SHAFT_PARTS + (wide)brake->part +
                         (brake->prpm < 0 ? -way : way);
        const wide off = end - (wide)(i % 2 == 0 ? target : -target) * (wide)DG_SHAFT_PARTS;
        assert_true(off > -512 && off < 512);
        braked++;
    }
    assert_true(braked > 1000);
}

/* Years at any speed, in any direction, modulo 2^64: as a motion does it. */
static void huge_times_wrap(void **state)
{
    static const dg_ns times[] = {DG_S(1),          DG_S(100000000), DG_NEVER / 2,
                                  DG_NEVER / 2 + 1, DG_NEVER - 1,    DG_NEVER};
    uint64_t seed = 4;

    (void)state;
    for (int i = 0; i < 20000; i++) {
        struct dg_shaft shaft = fresh(0);
        const dg_angle from = (dg_angle)random_bits(&seed);
        const int32_t mrpm = random_mrpm(&seed);
        const dg_ns now = i % 2 == 0 ? times[(size_t)i / 2 % DG_COUNT(times)] : random_bits(&seed);
        struct dg_motion motion = {.kind = DG_MOTION_SPEED, .from = from, .mrpm = mrpm};

        (void)dg_shaft_set_position(&shaft, 0, from);
        (void)dg_shaft_set_velocity(&shaft, 0, mrpm);
        assert_true(dg_shaft_angle(&shaft, now) == dg_motion_angle(&motion, now));
        assert_int_equal(dg_shaft_mrpm(&shaft, now), mrpm);
    }
}

/* 63 years up and down at the lowest acceleration. */
static void the_longest_speed_change(void **state)
{
    struct dg_shaft shaft = fresh(1);
    const dg_ns half = DG_S(SPEED_MAX);

    (void)state;
    (void)dg_shaft_set_velocity(&shaft, 0, -SPEED_MAX);
    assert_true(dg_shaft_settled(&shaft) == half);
    (void)dg_shaft_set_velocity(&shaft, half, SPEED_MAX);
    assert_true(dg_shaft_settled(&shaft) == 3 * half);
    assert_int_equal(dg_shaft_mrpm(&shaft, 2 * half), 0);
    assert_true(dg_shaft_angle(&shaft, 3 * half) == dg_shaft_angle(&shaft, half));
    assert_true(dg_shaft_angle(&shaft, half + DG_S(1)) ==
                dg_shaft_angle(&shaft, 3 * half - DG_S(1)));
}

static void a_motion_is_played_and_left(void **state)
{
    const struct dg_motion ramp = {.kind = DG_MOTION_RAMP,
                                   .start = 99,
                                   .from = DG_TURN,
                                   .mrpm = REV_PER_S,
                                   .accel = DG_S(1),
                                   .hold = DG_NEVER};
    struct dg_shaft shaft = fresh(REV_PER_S2);

    (void)state;
    assert_int_equal(dg_shaft_play(&shaft, DG_S(5), &ramp), DG_OK);
    assert_true(dg_shaft_settled(&shaft) == DG_NEVER);
    assert_true(dg_shaft_angle(&shaft, DG_S(5) - 1) == 0);
    assert_true(dg_shaft_angle(&shaft, DG_S(5)) == DG_TURN);
    assert_true(dg_shaft_angle(&shaft, DG_S(6)) == DG_TURN * 3 / 2);
    /* The mean of the millisecond before, of the first one in that one. */
    assert_in_range(dg_shaft_mrpm(&shaft, DG_S(5)), 29, 31);
    assert_in_range(dg_shaft_mrpm(&shaft, DG_S(5) + DG_MS(500)), 29969, 29971);
    assert_int_equal(dg_shaft_mrpm(&shaft, DG_S(9)), REV_PER_S);
    assert_int_equal(dg_shaft_set_velocity(&shaft, DG_S(9), 0), DG_OK);
    assert_true(dg_shaft_angle(&shaft, DG_S(9)) == DG_TURN * 9 / 2);
    assert_in_range(dg_shaft_angle(&shaft, DG_S(10)), DG_TURN * 5 - DG_TURN / 10000, DG_TURN * 5);
    assert_int_equal(dg_shaft_mrpm(&shaft, DG_S(10)), 0);
    /* What was played is still there for those who look back. */
    assert_true(dg_shaft_angle(&shaft, DG_S(6)) == DG_TURN * 3 / 2);
    assert_int_equal(dg_shaft_mrpm(&shaft, DG_S(8)), REV_PER_S);
}

/* At every moment, and so is the course that follows it. */
static void a_played_speed_is_exact(void **state)
{
    uint64_t seed = 6;

    (void)state;
    for (int i = 0; i < 20000; i++) {
        const struct dg_motion motion = {.kind = DG_MOTION_SPEED,
                                         .from = (dg_angle)random_bits(&seed),
                                         .mrpm = i % 2 == 0 ? REV_PER_S : random_mrpm(&seed)};
        const dg_ns begin = random_up_to(&seed, DG_S(10));
        const dg_ns now = begin + random_up_to(&seed, DG_S(10));
        struct dg_shaft shaft = fresh(1);

        assert_int_equal(dg_shaft_play(&shaft, begin, &motion), DG_OK);
        assert_int_equal(dg_shaft_mrpm(&shaft, begin), motion.mrpm);
        assert_int_equal(dg_shaft_mrpm(&shaft, now), motion.mrpm);
        (void)dg_shaft_set_velocity(&shaft, now, motion.mrpm);
        assert_true(dg_shaft_settled(&shaft) == now);
    }
}

/* A mean is 60000000 / 2^32 = 234375 / 2^24 of the travel in a millisecond. */
static void a_played_mean_is_the_nearest(void **state)
{
    static const struct {
        dg_angle travel;
        int32_t mrpm;
    } rows[] = {
        {0, 0},
        {35, 0},
        {36, 1}, /* 0.489, 0.503 */
        {107, 1},
        {108, 2}, /* 1.495, 1.509 */
        {8388607, 117187},
        {8388608, 117188}, /* .486, .5 */
        {8388609, 117188},
        {DG_TURN, 60000000},
    };

    (void)state;
    for (size_t i = 0; i < 2 * DG_COUNT(rows); i++) {
        const int sign = i % 2 == 0 ? 1 : -1;
        const struct dg_motion_point points[] = {{0, 5}, {DG_MS(1), 5 + sign * rows[i / 2].travel}};
        const struct dg_motion line = {
            .kind = DG_MOTION_REPLAY, .points = points, .point_count = DG_COUNT(points)};
        struct dg_shaft shaft = fresh(0);

        assert_int_equal(dg_shaft_play(&shaft, DG_S(1), &line), DG_OK);
        assert_int_equal(dg_shaft_mrpm(&shaft, DG_S(1) + DG_MS(1)), sign * rows[i / 2].mrpm);
    }
}

/* A replay may jump further than any shaft can turn; the stop after it begins at the limit. */
static void a_jump_is_left_at_the_highest_speed(void **state)
{
    static const struct dg_motion_point there[] = {{0, 0}, {DG_MS(1), 1000 * DG_TURN}};
    static const struct dg_motion_point back[] = {{0, 0}, {DG_MS(1), -1000 * DG_TURN}};
    const struct dg_motion_point *const points[] = {there, back};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(points); i++) {
        const struct dg_motion jump = {
            .kind = DG_MOTION_REPLAY, .points = points[i], .point_count = 2};
        const int32_t wanted = i == 0 ? SPEED_MAX : -SPEED_MAX;
        struct dg_shaft shaft = fresh(1000000);

        assert_int_equal(dg_shaft_play(&shaft, 0, &jump), DG_OK);
        (void)dg_shaft_set_velocity(&shaft, DG_MS(1), 0);
        assert_true(dg_shaft_angle(&shaft, DG_MS(1)) == points[i][1].angle);
        assert_int_equal(dg_shaft_mrpm(&shaft, DG_MS(1)), wanted);
        assert_true(dg_shaft_settled(&shaft) == DG_MS(1) + DG_S(1000));
    }
}

static void gears_are_exact(void **state)
{
    static const int32_t edges[] = {1, -1, 7, -7, INT32_MAX, -INT32_MAX, INT32_MIN, 0};
    static const dg_angle angles[] = {0,         1,        -1, 41, -41, DG_TURN, -DG_TURN - 1,
                                      INT64_MAX, INT64_MIN};
    uint64_t seed = 5;

    (void)state;
    for (int i = 0; i < 30000; i++) {
        struct dg_shaft driver = fresh(0);
        struct dg_shaft shaft = fresh(0);
        const dg_angle at =
            i % 2 == 0 ? angles[(size_t)i / 2 % DG_COUNT(angles)] : (dg_angle)random_bits(&seed);
        const int32_t numerator =
            i % 3 == 0 ? edges[(size_t)i / 3 % DG_COUNT(edges)] : (int32_t)random_bits(&seed);
        const int32_t denominator = (int32_t)random_up_to(&seed, INT32_MAX);

        assert_int_equal(dg_shaft_couple(&shaft, &driver, numerator, denominator), DG_OK);
        (void)dg_shaft_set_position(&driver, 0, at);
        assert_true(dg_shaft_angle(&shaft, 0) ==
                    wrapped(floor_div((wide)at * numerator, denominator)));
    }
}

static void a_geared_shaft_follows(void **state)
{
    struct dg_shaft driver = fresh(REV_PER_S2);
    struct dg_shaft shaft = fresh(0);

    (void)state;
    assert_int_equal(dg_shaft_couple(&shaft, &driver, -1, 10), DG_OK);
    assert_int_equal(dg_shaft_set_position(&shaft, DG_S(1), DG_TURN), DG_OK);
    assert_int_equal(dg_shaft_move(&driver, DG_S(1), 100 * DG_TURN, 10 * REV_PER_S), DG_OK);
    assert_true(dg_shaft_settled(&shaft) == dg_shaft_settled(&driver));
    assert_true(dg_shaft_angle(&shaft, DG_S(1)) == DG_TURN);
    assert_true(dg_shaft_angle(&shaft, DG_S(11)) == DG_TURN - 5 * DG_TURN);
    assert_int_equal(dg_shaft_mrpm(&shaft, DG_S(11)), -REV_PER_S);
    assert_true(dg_shaft_angle(&shaft, DG_S(21)) == DG_TURN - 10 * DG_TURN);
    /* It goes on turning from the new angle. */
    assert_int_equal(dg_shaft_set_position(&shaft, DG_S(11), 0), DG_OK);
    assert_true(dg_shaft_angle(&shaft, DG_S(11)) == 0);
    assert_true(dg_shaft_angle(&shaft, DG_S(21)) == -5 * DG_TURN);
}

/* Another gear begins without the offset of the one before. */
static void coupled_again_it_has_no_offset(void **state)
{
    struct dg_shaft driver = fresh(0);
    struct dg_shaft shaft = fresh(0);

    (void)state;
    assert_int_equal(dg_shaft_set_position(&driver, 0, 10 * DG_TURN), DG_OK);
    assert_int_equal(dg_shaft_couple(&shaft, &driver, 1, 1), DG_OK);
    assert_int_equal(dg_shaft_set_position(&shaft, 0, 3 * DG_TURN), DG_OK);
    assert_true(dg_shaft_angle(&shaft, 0) == 3 * DG_TURN);
    assert_int_equal(dg_shaft_couple(&shaft, &driver, 1, 5), DG_OK);
    assert_true(dg_shaft_angle(&shaft, 0) == 2 * DG_TURN);
}

static void speeds_behind_a_gear_saturate(void **state)
{
    struct dg_shaft driver = fresh(0);
    struct dg_shaft shaft = fresh(0);

    (void)state;
    (void)dg_shaft_set_velocity(&driver, 0, SPEED_MAX);
    (void)dg_shaft_couple(&shaft, &driver, 3, 1);
    assert_int_equal(dg_shaft_mrpm(&shaft, 5), INT32_MAX);
    (void)dg_shaft_couple(&shaft, &driver, -3, 1);
    assert_int_equal(dg_shaft_mrpm(&shaft, 5), -INT32_MAX);
    (void)dg_shaft_couple(&shaft, &driver, -1, 3);
    assert_int_equal(dg_shaft_mrpm(&shaft, 5), -333333333);
}

/* 8 gears in a row of 1:2 each, and no ninth; no loops of any length. */
static void gears_in_a_row(void **state)
{
    struct dg_shaft shafts[DG_SHAFT_GEARS_MAX + 2];

    (void)state;
    for (size_t i = 0; i < DG_COUNT(shafts); i++) {
        shafts[i] = fresh(0);
        assert_int_equal(dg_shaft_couple(&shafts[i], &shafts[i], 1, 1), DG_ERR_ARGUMENT);
        if (i > 0) {
            assert_int_equal(dg_shaft_couple(&shafts[i], &shafts[i - 1], 1, 2),
                             i <= DG_SHAFT_GEARS_MAX ? DG_OK : DG_ERR_ARGUMENT);
        }
    }
    for (size_t i = 0; i <= DG_SHAFT_GEARS_MAX; i++) {
        assert_int_equal(dg_shaft_couple(&shafts[0], &shafts[i], 1, 1), DG_ERR_ARGUMENT);
    }
    assert_null(shafts[0].driver);
    (void)dg_shaft_set_position(&shafts[0], 0, 3 * DG_TURN);
    assert_true(dg_shaft_angle(&shafts[DG_SHAFT_GEARS_MAX], 0) == 3 * DG_TURN / 256);
    (void)dg_shaft_set_position(&shafts[0], 0, -1);
    assert_true(dg_shaft_angle(&shafts[DG_SHAFT_GEARS_MAX], 0) == -1);
}

static void what_is_out_of_range_is_refused(void **state)
{
    const struct dg_motion none = {.kind = DG_MOTION_KIND_COUNT};
    struct dg_shaft shaft = fresh(DG_SHAFT_ACCELERATION_MAX);
    struct dg_shaft same;
    struct dg_shaft driver = fresh(0);

    (void)state;
    (void)dg_shaft_set_velocity(&shaft, 5, -SPEED_MAX);
    memcpy(&same, &shaft, sizeof shaft);
    assert_int_equal(dg_shaft_set_acceleration(&shaft, -1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_set_acceleration(&shaft, DG_SHAFT_ACCELERATION_MAX + 1),
                     DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_set_velocity(&shaft, 9, SPEED_MAX + 1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_set_velocity(&shaft, 9, -SPEED_MAX - 1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_move(&shaft, 9, 0, 0), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_move(&shaft, 9, 0, -1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_move(&shaft, 9, 0, SPEED_MAX + 1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_play(&shaft, 9, &none), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_couple(&shaft, &driver, 1, 0), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_couple(&shaft, &driver, 1, -1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_couple(&shaft, NULL, 1, 1), DG_ERR_ARGUMENT);
    assert_memory_equal(&shaft, &same, sizeof shaft);
}

static void a_geared_shaft_takes_no_commands(void **state)
{
    const struct dg_motion rest = {.kind = DG_MOTION_STANDSTILL};
    struct dg_shaft driver = fresh(0);
    struct dg_shaft shaft = fresh(0);
    struct dg_shaft same;

    (void)state;
    (void)dg_shaft_couple(&shaft, &driver, 1, 1);
    memcpy(&same, &shaft, sizeof shaft);
    assert_int_equal(dg_shaft_set_acceleration(&shaft, 1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_set_velocity(&shaft, 9, 0), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_move(&shaft, 9, 0, 1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_shaft_play(&shaft, 9, &rest), DG_ERR_ARGUMENT);
    assert_memory_equal(&shaft, &same, sizeof shaft);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_new_shaft_rests),
        cmocka_unit_test(without_acceleration_all_is_at_once),
        cmocka_unit_test(speed_changes_by_hand),
        cmocka_unit_test(the_same_speed_again_changes_nothing),
        cmocka_unit_test(looking_back),
        cmocka_unit_test(encoders_see_the_speed_between_commands),
        cmocka_unit_test(turning_on_at_once),
        cmocka_unit_test(no_drift_at_a_constant_speed),
        cmocka_unit_test(no_drift_over_many_speed_changes),
        cmocka_unit_test(braking_ends_at_the_target),
        cmocka_unit_test(huge_times_wrap),
        cmocka_unit_test(the_longest_speed_change),
        cmocka_unit_test(a_motion_is_played_and_left),
        cmocka_unit_test(a_played_speed_is_exact),
        cmocka_unit_test(a_played_mean_is_the_nearest),
        cmocka_unit_test(a_jump_is_left_at_the_highest_speed),
        cmocka_unit_test(gears_are_exact),
        cmocka_unit_test(a_geared_shaft_follows),
        cmocka_unit_test(coupled_again_it_has_no_offset),
        cmocka_unit_test(speeds_behind_a_gear_saturate),
        cmocka_unit_test(gears_in_a_row),
        cmocka_unit_test(what_is_out_of_range_is_refused),
        cmocka_unit_test(a_geared_shaft_takes_no_commands),
    };

    return cmocka_run_group_tests_name("steer", tests, NULL, NULL);
}
