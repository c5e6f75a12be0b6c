/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/wide.h"
#include "effort.h"
#include "motion_model.h"

/* The unbounded integers everything is checked against. */
__extension__ typedef unsigned __int128 uwide;

static const uint64_t EDGES[] = {1,
                                 2,
                                 3,
                                 UINT32_MAX,
                                 (uint64_t)UINT32_MAX + 1,
                                 (uint64_t)UINT32_MAX + 2,
                                 ((uint64_t)1 << 62) - 1,
                                 INT64_MAX,
                                 (uint64_t)INT64_MAX + 1,
                                 (uint64_t)INT64_MAX + 2,
                                 UINT64_MAX - 1,
                                 UINT64_MAX};

/** A number with long runs of zeros and ones as often as any other one. */
static uint64_t random_number(uint64_t *seed)
{
    const uint64_t bits = random_bits(seed);
    const unsigned shift = (unsigned)(random_bits(seed) % 64u);

    switch (random_bits(seed) % 4u) {
    case 0:
        return bits >> shift;
    case 1:
        return ~(bits >> shift);
    case 2:
        return ((uint64_t)1 << shift) + bits % 5u - 2u;
    default:
        return bits << shift;
    }
}

static void products_are_whole(void **state)
{
    const uint32_t rounds = effort(100000, 1000000);
    uint64_t seed = 1;

    (void)state;
    for (uint32_t i = 0; i < rounds; i++) {
        const uint64_t a = random_number(&seed);
        const uint64_t b = random_number(&seed);
        const struct dg_wide product = dg_wide_product(a, b);

        assert_true(((uwide)product.high << 64 | product.low) == (uwide)a * b);
        assert_true(dg_product((uint32_t)a, (uint32_t)b) == (uint64_t)(uint32_t)a * (uint32_t)b);
    }
}

static void check_reciprocal(uint64_t divisor)
{
    const struct dg_reciprocal by = dg_reciprocal_of(divisor);

    assert_true(by.divisor >> 63 == 1);
    assert_true(by.divisor == divisor << by.shift && by.divisor >> by.shift == divisor);
    assert_true(by.inverse == (uint64_t)((~(uwide)0) / by.divisor - ((uwide)1 << 64)));
}

static void check_division(uwide value, uint64_t divisor)
{
    const struct dg_reciprocal by = dg_reciprocal_of(divisor);
    const uwide shifted = value << by.shift;
    uint64_t rest;

    assert_true(dg_divide_by((struct dg_wide){(uint64_t)(shifted >> 64), (uint64_t)shifted}, &by,
                             &rest) == (uint64_t)(value / divisor));
    assert_true(rest >> by.shift == (uint64_t)(value % divisor));
}

static void reciprocals_are_exact(void **state)
{
    const uint32_t rounds = effort(200000, 5000000);
    uint64_t seed = 2;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(EDGES); i++) {
        check_reciprocal(EDGES[i]);
    }
    for (uint32_t i = 0; i < rounds; i++) {
        const uint64_t divisor = random_number(&seed);

        check_reciprocal(divisor != 0 ? divisor : 1);
    }
}

static void divisions_are_exact(void **state)
{
    const uint32_t rounds = effort(200000, 5000000);
    uint64_t seed = 3;

    (void)state;
    for (size_t d = 0; d < DG_COUNT(EDGES); d++) {
        for (size_t q = 0; q < DG_COUNT(EDGES); q++) { /* both sides of a whole quotient */
            check_division((uwide)EDGES[d] * EDGES[q], EDGES[d]);
            check_division((uwide)EDGES[d] * EDGES[q] - 1, EDGES[d]);
            check_division((uwide)EDGES[d] * EDGES[q] + EDGES[d] - 1, EDGES[d]);
        }
    }
    for (uint32_t i = 0; i < rounds; i++) {
        const uint64_t any = random_number(&seed);
        const uint64_t divisor = any != 0 ? any : 1;
        const uwide whole = (uwide)divisor * random_number(&seed);

        check_division(whole, divisor);
        check_division(whole + divisor - 1, divisor);
        check_division(whole + random_number(&seed) % divisor, divisor);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(products_are_whole),
        cmocka_unit_test(reciprocals_are_exact),
        cmocka_unit_test(divisions_are_exact),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
