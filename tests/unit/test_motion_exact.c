/* SPDX-License-Identifier: MIT */
/*
 * Motions to the unit, against unbounded integers: where an error of a reciprocal would show first,
 * and with reciprocals of other figures than the motion's.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/motion.h"
#include "effort.h"
#include "motion_model.h"

/** 0.001 rpm in units of 2^-32 turn per nanosecond: 2^32 / 6e13 = 2^18 / MRPM_DIVISOR. */
#define MRPM_DIVISOR 3662109375
#define AMPLITUDE_MAX ((dg_angle)1 << 40)

static struct dg_motion accepted(struct dg_motion wanted)
{
    struct dg_motion motion;

    assert_int_equal(dg_motion_set(&motion, &wanted), DG_OK);
    return motion;
}

/* As slope_q20() and at_full_speed() have it: floor of the one, then floor of the other. */
static dg_angle ramp_by_floors(const struct dg_motion *m, dg_ns t)
{
    const wide accel = (wide)m->accel;
    const wide hold = (wide)m->hold;
    const wide left = 2 * accel + hold - (wide)t;
    wide time_q20;

    if ((wide)t < accel) {
        time_q20 = (wide)t * t * 524288 / accel;
    } else if ((wide)t <= accel + hold) {
        time_q20 = ((wide)t - accel) * 1048576 + accel * 524288;
    } else {
        time_q20 = (hold + accel) * 1048576 - (left > 0 ? left * left * 524288 / accel : 0);
    }
    return wrapped(m->from + floor_div(m->mrpm * time_q20, 4 * (wide)MRPM_DIVISOR));
}

static void ramp_is_the_same_to_the_unit(void **state)
{
    const uint32_t rounds = effort(40000, 1000000);
    uint64_t seed = 9;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        const struct dg_motion m =
            accepted((struct dg_motion){.kind = DG_MOTION_RAMP,
                                        .from = (dg_angle)random_bits(&seed),
                                        .mrpm = random_mrpm(&seed),
                                        .accel = random_up_to(&seed, DG_MOTION_RAMP_MAX),
                                        .hold = random_up_to(&seed, DG_NEVER / 2)});
        const dg_ns joints[] = {0, m.accel, m.accel + m.hold, 2 * m.accel + m.hold};

        for (size_t j = 0; j < DG_COUNT(joints); j++) {
            const dg_ns near = joints[j] + random_up_to(&seed, m.accel) - random_up_to(&seed, 3);

            assert_true(dg_motion_angle((void *)&m, near) == ramp_by_floors(&m, near));
        }
    }
}

/** x with a * x = 1 modulo m; a and m have no common factor. */
static uint64_t inverse_modulo(uint64_t a, uint64_t m)
{
    wide x = 1;
    wide next_x = 0;
    wide rest = (wide)(a % m);
    wide next = (wide)m;

    while (next != 0) {
        const wide quotient = rest / next;
        const wide after = rest - quotient * next;
        const wide x_after = x - quotient * next_x;

        rest = next;
        next = after;
        x = next_x;
        next_x = x_after;
    }
    return (uint64_t)(x < 0 ? x + (wide)m : x);
}

/** The latest moments at which `factor` * t / divisor is whole, and 1 / divisor more and less. */
static void worst_moments(uint64_t factor, uint64_t divisor, dg_ns t[3])
{
    const uint64_t more = inverse_modulo(factor, divisor) % divisor;
    const uint64_t last = UINT64_MAX / divisor - 1;

    t[0] = last * divisor;
    t[1] = last * divisor + more;
    t[2] = last * divisor + (divisor - more) % divisor;
}

/* Where an error of a reciprocal would show first. */
static void speed_is_exact_where_it_is_hardest(void **state)
{
    const uint32_t rounds = effort(20000, 500000);
    uint64_t seed = 10;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        const struct dg_motion m =
            accepted((struct dg_motion){.kind = DG_MOTION_SPEED, .mrpm = random_mrpm(&seed)});
        const uint64_t mrpm = (uint64_t)(m.mrpm < 0 ? -m.mrpm : m.mrpm);
        dg_ns t[3];

        if (mrpm % 3 == 0 || mrpm % 5 == 0) { /* the divisor is 3 * 5^13 */
            continue;
        }
        worst_moments(mrpm * 262144 % MRPM_DIVISOR, MRPM_DIVISOR, t);
        for (int j = 0; j < 3; j++) {
            assert_true(dg_motion_angle((void *)&m, t[j]) ==
                        wrapped(floor_div((wide)m.mrpm * t[j] * 262144, MRPM_DIVISOR)));
        }
    }
}

static dg_angle sine_by_floors(const struct dg_motion *m, dg_ns t)
{
    const wide half_units = (wide)(t % m->period) * ((wide)1 << 33) / (wide)m->period;
    const int64_t sine = dg_sin_q30((uint32_t)((half_units + 1) >> 1));
    const wide amplitude = m->amplitude < 0 ? -(wide)m->amplitude : m->amplitude;
    const wide moved = amplitude * (sine < 0 ? -sine : sine) >> 30;

    return wrapped(m->from + ((sine < 0) != (m->amplitude < 0) ? -moved : moved));
}

static void sine_is_the_same_to_the_unit(void **state)
{
    const uint32_t rounds = effort(20000, 500000);
    uint64_t seed = 11;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        const struct dg_motion m = accepted(
            (struct dg_motion){.kind = DG_MOTION_SINE,
                               .from = (dg_angle)random_bits(&seed),
                               .amplitude = (dg_angle)random_up_to(&seed, AMPLITUDE_MAX) - i % 2,
                               .period = random_up_to(&seed, DG_MOTION_PERIOD_MAX)});
        const dg_ns any = random_up_to(&seed, DG_NEVER - 1);
        dg_ns t[3] = {any, any, any};

        if (m.period % 2 != 0) {
            worst_moments((uint64_t)1 << 33, m.period, t);
        }
        for (int j = 0; j < 3; j++) {
            assert_true(dg_motion_angle((void *)&m, t[j]) == sine_by_floors(&m, t[j]));
        }
    }
}

/* Odd half units, which are rounded up: the period has a factor of 2^33. */
static void sine_rounds_up_in_the_middle(void **state)
{
    uint64_t seed = 13;

    (void)state;
    for (uint32_t i = 0; i < 20000; i++) {
        const uint64_t odd = 2 * random_up_to(&seed, 5000) - 1;
        const struct dg_motion m = accepted((struct dg_motion){
            .kind = DG_MOTION_SINE, .amplitude = AMPLITUDE_MAX, .period = odd << 33});
        const dg_ns t = odd * (random_up_to(&seed, UINT64_MAX / odd / 2) * 2 - 1);

        assert_true(dg_motion_angle((void *)&m, t) == sine_by_floors(&m, t));
    }
}

/* What dg_motion_set() made is of the figures then; a motion that has others, or was never set,
 * turns as if it had been. */
static void a_motion_that_was_changed_turns_as_it_says(void **state)
{
    const uint32_t rounds = effort(5000, 100000);
    uint64_t seed = 12;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        struct dg_motion m = {.kind = i % 3 == 0   ? DG_MOTION_SPEED
                                      : i % 3 == 1 ? DG_MOTION_RAMP
                                                   : DG_MOTION_SINE,
                              .mrpm = random_mrpm(&seed),
                              .accel = random_up_to(&seed, DG_MOTION_RAMP_MAX),
                              .hold = random_up_to(&seed, DG_MOTION_RAMP_MAX),
                              .amplitude = (dg_angle)random_up_to(&seed, AMPLITUDE_MAX),
                              .period = random_up_to(&seed, DG_MOTION_RAMP_MAX)};
        struct dg_motion set = accepted(m);
        struct dg_motion changed = accepted((struct dg_motion){
            .kind = m.kind, .mrpm = 5, .accel = m.period, .amplitude = 9, .period = m.accel});
        const dg_ns t = random_up_to(&seed, 2 * DG_MOTION_RAMP_MAX);

        changed.mrpm = m.mrpm;
        changed.accel = m.accel;
        changed.hold = m.hold;
        changed.amplitude = m.amplitude;
        changed.period = m.period;
        assert_true(dg_motion_angle(&m, t) == dg_motion_angle(&set, t));
        assert_true(dg_motion_angle(&changed, t) == dg_motion_angle(&set, t));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ramp_is_the_same_to_the_unit),
        cmocka_unit_test(speed_is_exact_where_it_is_hardest),
        cmocka_unit_test(sine_is_the_same_to_the_unit),
        cmocka_unit_test(sine_rounds_up_in_the_middle),
        cmocka_unit_test(a_motion_that_was_changed_turns_as_it_says),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
