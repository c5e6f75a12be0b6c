/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/angle.h"
#include "effort.h"
#include "motion_model.h"

/* The unbounded integers everything is checked against. */
__extension__ typedef unsigned __int128 uwide;

static const int64_t EDGES[] = {
    0,
    1,
    -1,
    2,
    -2,
    65535,
    -65536,
    DG_TURN - 1,
    DG_TURN,
    DG_TURN + 1,
    -DG_TURN - 1,
    -DG_TURN,
    -DG_TURN + 1,
    DG_TURN / 2,
    -DG_TURN / 2,
    INT64_MAX,
    INT64_MAX - 1,
    INT64_MAX - DG_TURN,
    INT64_MIN,
    INT64_MIN + 1,
    INT64_MIN + DG_TURN,
};

static const uint32_t RESOLUTIONS[] = {
    1,     2,       3,          7,          10,         65535,          65536,
    65537, 1000003, 0x7FFFFFFF, 0x80000000, 0x80000001, UINT32_MAX - 1, UINT32_MAX};

/** A number of random length, so that small ones are as frequent as large ones. */
static uint64_t random_length(uint64_t *seed)
{
    uint64_t bits = random_bits(seed);

    return bits >> (random_bits(seed) % 64);
}

static int64_t random_signed(uint64_t *seed)
{
    int64_t magnitude = (int64_t)(random_length(seed) >> 1);

    return (random_bits(seed) & 1) != 0 ? magnitude : -1 - magnitude;
}

static uint32_t random_resolution(uint64_t *seed)
{
    uint32_t resolution = (uint32_t)random_length(seed);

    return resolution != 0 ? resolution : 1;
}

static void check_counts(dg_angle angle, uint32_t resolution)
{
    assert_true(dg_angle_counts(angle, resolution) == floor_div((wide)angle * resolution, DG_TURN));
}

static void counts_are_the_exact_floor(void **state)
{
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 1;

    (void)state;
    for (size_t a = 0; a < DG_COUNT(EDGES); a++) {
        for (size_t r = 0; r < DG_COUNT(RESOLUTIONS); r++) {
            check_counts(EDGES[a], RESOLUTIONS[r]);
        }
    }
    for (uint32_t i = 0; i < rounds; i++) {
        check_counts(random_signed(&seed), random_resolution(&seed));
    }
}

static void counts_are_equally_wide_around_zero(void **state)
{
    (void)state;
    assert_int_equal(dg_angle_counts(0, 65536), 0);
    assert_int_equal(dg_angle_counts(65535, 65536), 0);
    assert_int_equal(dg_angle_counts(65536, 65536), 1);
    assert_int_equal(dg_angle_counts(-1, 65536), -1);
    assert_int_equal(dg_angle_counts(-65536, 65536), -1);
    assert_int_equal(dg_angle_counts(-65537, 65536), -2);
    assert_int_equal(dg_angle_counts(-DG_TURN, 65536), -65536);
}

/** `counts` where the angle fits its type: the exact ceiling, and the first angle to give it. */
static void check_angle_of(int64_t counts, uint32_t resolution)
{
    wide exact = -floor_div(-((wide)counts * DG_TURN), resolution);
    dg_angle angle = dg_angle_of_counts(counts, resolution);

    assert_true(angle == exact);
    assert_true(dg_angle_counts(angle, resolution) == counts);
    assert_true(angle == INT64_MIN || dg_angle_counts(angle - 1, resolution) == counts - 1);
}

static bool angle_fits(int64_t counts, uint32_t resolution)
{
    wide exact = -floor_div(-((wide)counts * DG_TURN), resolution);

    return exact >= INT64_MIN && exact <= INT64_MAX;
}

static void angle_of_counts_is_the_exact_ceiling(void **state)
{
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 2;
    int checked = 0;

    (void)state;
    for (size_t a = 0; a < DG_COUNT(EDGES); a++) {
        for (size_t r = 0; r < DG_COUNT(RESOLUTIONS); r++) {
            int64_t counts = dg_angle_counts(EDGES[a], RESOLUTIONS[r]);

            for (int64_t near = -1; near <= 1; near++) {
                if (angle_fits(counts + near, RESOLUTIONS[r])) {
                    check_angle_of(counts + near, RESOLUTIONS[r]);
                    checked++;
                }
            }
        }
    }
    assert_true(checked > 500);
    for (uint32_t i = 0; i < rounds; i++) {
        uint32_t resolution = random_resolution(&seed);
        /* Of half the type's range: the count's first angle fits the type, too. */
        int64_t counts = dg_angle_counts(random_signed(&seed) / 2, resolution);

        check_angle_of(counts, resolution);
    }
}

static void mod_is_never_negative(void **state)
{
    static const uint64_t ranges[] = {
        1, 2, 3, 16, 65536, 268435456, 1000000007, ((uint64_t)1 << 62) - 1, (uint64_t)1 << 62};
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 3;

    (void)state;
    for (size_t a = 0; a < DG_COUNT(EDGES); a++) {
        for (size_t r = 0; r < DG_COUNT(ranges); r++) {
            wide range = (wide)ranges[r];

            assert_true((wide)dg_mod(EDGES[a], ranges[r]) ==
                        EDGES[a] - floor_div(EDGES[a], range) * range);
        }
    }
    for (uint32_t i = 0; i < rounds; i++) {
        int64_t value = random_signed(&seed);
        wide range = (wide)(random_length(&seed) >> 2) + 1;

        assert_true((wide)dg_mod(value, (uint64_t)range) ==
                    value - floor_div(value, range) * range);
    }
}

static void check_muldiv(uint64_t a, uint64_t b, uint64_t c)
{
    uwide quotient = (uwide)a * b / c;

    assert_true(dg_muldiv(a, b, c) == (quotient > UINT64_MAX ? UINT64_MAX : (uint64_t)quotient));
}

static void muldiv_keeps_the_whole_product(void **state)
{
    static const uint64_t edges[] = {0,
                                     1,
                                     2,
                                     3,
                                     UINT32_MAX,
                                     (uint64_t)UINT32_MAX + 1,
                                     (uint64_t)UINT32_MAX + 2,
                                     INT64_MAX,
                                     (uint64_t)INT64_MAX + 1,
                                     UINT64_MAX - 1,
                                     UINT64_MAX};
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 4;

    (void)state;
    for (size_t a = 0; a < DG_COUNT(edges); a++) {
        for (size_t b = 0; b < DG_COUNT(edges); b++) {
            for (size_t c = 1; c < DG_COUNT(edges); c++) {
                check_muldiv(edges[a], edges[b], edges[c]);
            }
        }
    }
    for (uint32_t i = 0; i < rounds; i++) {
        uint64_t a = random_length(&seed);
        uint64_t b = random_length(&seed);
        uint64_t c = random_length(&seed);

        check_muldiv(a, b, c != 0 ? c : 1);
        /* One factor below the divisor: the quotient always fits, so nothing saturates. */
        check_muldiv(a, b, (a < b ? a : b) + 1);
    }
}

static void muldiv_saturates(void **state)
{
    (void)state;
    assert_true(dg_muldiv(0, 0, 0) == UINT64_MAX);
    assert_true(dg_muldiv(5, 7, 0) == UINT64_MAX);
    assert_true(dg_muldiv(UINT64_MAX, 2, 1) == UINT64_MAX);
    assert_true(dg_muldiv(UINT64_MAX, UINT64_MAX, UINT64_MAX - 1) == UINT64_MAX);
    assert_true(dg_muldiv(UINT64_MAX, UINT64_MAX, UINT64_MAX) == UINT64_MAX);
    assert_true(dg_muldiv(UINT64_MAX - 1, UINT64_MAX, UINT64_MAX) == UINT64_MAX - 1);
}

static long double sine_error(uint32_t phase)
{
    const long double pi = 3.14159265358979323846264338327950288L;

    return (long double)dg_sin_q30(phase) - sinl((long double)phase * 0x1p-31L * pi) * 0x1p30L;
}

static void sine_is_within_its_error(void **state)
{
    const uint32_t step = effort(14305, 2861);
    long double worst = 0;

    (void)state;
    /* An odd step: up to 1.5 million phases over the whole period, and every one near 0. */
    for (uint64_t phase = 0; phase < (uint64_t)1 << 32; phase += step) {
        worst = fmaxl(worst, fabsl(sine_error((uint32_t)phase)));
    }
    for (uint32_t phase = 0; phase < 100000; phase++) {
        worst = fmaxl(worst, fabsl(sine_error(phase - 50000u)));
    }
    assert_true(worst < 1.2L);
    assert_true(worst > 0.5L); /* the comparison does compare */
}

static void sine_is_exact_at_the_quarters(void **state)
{
    (void)state;
    assert_int_equal(dg_sin_q30(0), 0);
    assert_int_equal(dg_sin_q30(0x40000000), 0x40000000);
    assert_int_equal(dg_sin_q30(0x80000000), 0);
    assert_int_equal(dg_sin_q30(0xC0000000), -0x40000000);
}

static void sine_is_symmetric_and_bounded(void **state)
{
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 5;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        uint32_t phase = (uint32_t)random_bits(&seed);
        int32_t sine = dg_sin_q30(phase);

        assert_int_equal(dg_sin_q30(0 - phase), -sine);
        assert_int_equal(dg_sin_q30(0x80000000 - phase), sine);
        assert_int_equal(dg_sin_q30(phase + 0x80000000), -sine);
        assert_in_range((int64_t)sine + 0x40000000, 0, 0x80000000);
    }
    for (uint32_t d = 0; d < 100000; d++) { /* flat around the peak, never above it */
        assert_true(dg_sin_q30(0x40000000 - d) <= 0x40000000);
        assert_int_equal(dg_sin_q30(0x40000000 - d), dg_sin_q30(0x40000000 + d));
    }
}

static void cosine_is_a_quarter_ahead(void **state)
{
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 6;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        uint32_t phase = (uint32_t)random_bits(&seed);
        int64_t sine = dg_sin_q30(phase);
        int64_t cosine = dg_sin_q30(phase + 0x40000000);
        int64_t excess = sine * sine + cosine * cosine - ((int64_t)1 << 60);

        /* 2 r dr with r = 2^30 and both errors below 1.2: below 2 * 1.2 * sqrt(2) * 2^30. */
        assert_true(excess < (int64_t)4 << 30 && excess > -((int64_t)4 << 30));
    }
}

static void check_isqrt(uint64_t value)
{
    uwide root = dg_isqrt(value);

    assert_true(root * root <= value);
    assert_true((root + 1) * (root + 1) > value);
}

static void isqrt_is_the_exact_floor(void **state)
{
    const uint32_t rounds = effort(40000, 200000);
    uint64_t seed = 7;

    (void)state;
    for (uint64_t value = 0; value < 70000; value++) {
        check_isqrt(value);
    }
    for (uint32_t i = 0; i < rounds; i++) {
        uint64_t root = (uint32_t)random_length(&seed);

        check_isqrt(random_length(&seed));
        check_isqrt(root * root);
        check_isqrt(root * root - (root > 0 ? 1 : 0));
    }
    assert_true(dg_isqrt(UINT64_MAX) == UINT32_MAX);
    assert_true(dg_isqrt((uint64_t)UINT32_MAX * UINT32_MAX) == UINT32_MAX);
    assert_true(dg_isqrt((uint64_t)UINT32_MAX * UINT32_MAX - 1) == UINT32_MAX - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_are_the_exact_floor),
        cmocka_unit_test(counts_are_equally_wide_around_zero),
        cmocka_unit_test(angle_of_counts_is_the_exact_ceiling),
        cmocka_unit_test(mod_is_never_negative),
        cmocka_unit_test(muldiv_keeps_the_whole_product),
        cmocka_unit_test(muldiv_saturates),
        cmocka_unit_test(sine_is_within_its_error),
        cmocka_unit_test(sine_is_exact_at_the_quarters),
        cmocka_unit_test(sine_is_symmetric_and_bounded),
        cmocka_unit_test(cosine_is_a_quarter_ahead),
        cmocka_unit_test(isqrt_is_the_exact_floor),
    };

    return cmocka_run_group_tests_name("angle", tests, NULL, NULL);
}
