/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "motion_private.h"

#define ROUNDS 100000

__extension__ typedef unsigned __int128 wide;

/** splitmix64, small and large ones alike */
static uint64_t random_bits(uint64_t *seed)
{
    uint64_t z = *seed += 0x9E3779B97F4A7C15u;
    unsigned shift = (unsigned)(*seed >> 58);

    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (z ^ (z >> 31)) >> shift;
}

static wide value_of(struct dg_wide a)
{
    return (wide)a.high << 64 | a.low;
}

static struct dg_wide wide_of(wide a)
{
    return (struct dg_wide){.high = (uint64_t)(a >> 64), .low = (uint64_t)a};
}

static void arithmetic_of_128_bits(void **state)
{
    uint64_t seed = 1;

    (void)state;
    for (int i = 0; i < ROUNDS; i++) {
        wide a = (wide)random_bits(&seed) << 64 | random_bits(&seed);
        wide b = (wide)random_bits(&seed) << 64 | random_bits(&seed);
        uint64_t c = random_bits(&seed);
        uint64_t d = random_bits(&seed) / 2 + 1;
        struct dg_wide x = wide_of(a);
        struct dg_wide y = wide_of(b);

        assert_true(value_of(dg_motion_wide_add(x, y)) == a + b);
        assert_true(value_of(dg_motion_wide_subtract(x, y)) == a - b);
        assert_true(value_of(dg_motion_wide_negate(x)) == 0 - a);
        assert_int_equal(dg_motion_wide_is_negative(x), a >> 127 != 0);
        assert_int_equal(dg_motion_wide_less(x, y), a < b);
        assert_false(dg_motion_wide_less(x, x));
        assert_true(value_of(dg_motion_wide_times(x, c)) == a * c);
        assert_true(value_of(dg_wide_product(x.low, c)) == (wide)x.low * c);
        assert_true(value_of(dg_motion_wide_divide(x, d)) == a / d);
    }
}

static void check_root(wide a)
{
    wide root = dg_motion_wide_sqrt(wide_of(a));

    assert_true(root * root <= a);
    assert_true(root == UINT64_MAX || (root + 1) * (root + 1) > a);
}

static void roots_of_128_bits(void **state)
{
    static const uint64_t edges[] = {0, 1, 2, 3, 4, UINT32_MAX, UINT64_MAX};
    uint64_t seed = 2;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(edges) * DG_COUNT(edges); i++) {
        check_root((wide)edges[i / DG_COUNT(edges)] << 64 | edges[i % DG_COUNT(edges)]);
    }
    for (int i = 0; i < ROUNDS / 10; i++) {
        uint64_t root = random_bits(&seed);

        check_root((wide)random_bits(&seed) << 64 | random_bits(&seed));
        assert_true(dg_motion_wide_sqrt(wide_of((wide)root * root)) == root);
        assert_true(root == 0 || dg_motion_wide_sqrt(wide_of((wide)root * root - 1)) == root - 1);
    }
}

static void directions(void **state)
{
    (void)state;
    assert_true(dg_motion_exact_magnitude(INT64_MIN) == (uint64_t)1 << 63);
    assert_true(dg_motion_exact_magnitude(-5) == 5 && dg_motion_exact_magnitude(5) == 5);
    assert_true(dg_motion_exact_moved(INT64_MAX, false, 1) == INT64_MIN);
    assert_true(dg_motion_exact_moved(INT64_MIN, true, 1) == INT64_MAX);
    assert_true(dg_motion_exact_muldiv(7, 3, 2, false) == 10);
    assert_true(dg_motion_exact_muldiv(7, 3, 2, true) == 11);
    assert_true(dg_motion_exact_muldiv(8, 3, 2, true) == 12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arithmetic_of_128_bits),
        cmocka_unit_test(roots_of_128_bits),
        cmocka_unit_test(directions),
    };

    return cmocka_run_group_tests_name("exact", tests, NULL, NULL);
}
