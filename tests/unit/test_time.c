/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/time.h"

static void spans_are_nanoseconds(void **state)
{
    (void)state;
    assert_true(DG_US(3) == 3000);
    assert_true(DG_MS(3) == 3000000);
    assert_true(DG_S(3) == 3000000000u);
    assert_true(DG_S(4294967295u) == 4294967295000000000u);
}

static void after_saturates(void **state)
{
    (void)state;
    assert_true(dg_after(5, 7) == 12);
    assert_true(dg_after(0, 0) == 0);
    assert_true(dg_after(DG_NEVER - 1, 1) == DG_NEVER);
    assert_true(dg_after(DG_NEVER - 1, 2) == DG_NEVER);
    assert_true(dg_after(DG_NEVER, 0) == DG_NEVER);
    assert_true(dg_after(1, DG_NEVER) == DG_NEVER);
    assert_true(dg_after(DG_NEVER, DG_NEVER) == DG_NEVER);
}

static void elapsed_never_runs_backwards(void **state)
{
    (void)state;
    assert_true(dg_elapsed(12, 5) == 7);
    assert_true(dg_elapsed(5, 5) == 0);
    assert_true(dg_elapsed(5, 12) == 0);
    assert_true(dg_elapsed(DG_NEVER, 0) == DG_NEVER);
    assert_true(dg_elapsed(0, DG_NEVER) == 0);
}

/* Against the machine's own division. */
static void spans_are_divided(void **state)
{
    static const uint16_t divisors[] = {1, 2, 100, 1000, 0x8000, 60000, 65535};
    uint64_t noise = 0x9E3779B97F4A7C15u;
    (void)state;

    for (int i = 0; i < 10000; i++) {
        const uint64_t span = i < 4 ? DG_NEVER - (uint64_t)i : noise >> i % 64;
        const uint16_t divisor = divisors[i % 7];
        assert_true(dg_divide_ns(span, divisor) == span / divisor);
        noise = noise * 6364136223846793005u + 1442695040888963407u;
    }
}

static void earliest_of_two(void **state)
{
    (void)state;
    assert_true(dg_earliest(3, 4) == 3);
    assert_true(dg_earliest(4, 3) == 3);
    assert_true(dg_earliest(DG_NEVER, 4) == 4);
    assert_true(dg_earliest(DG_NEVER, DG_NEVER) == DG_NEVER);
}

/* bits * 1e9 / baud, computed by hand. */
static void bit_times_round_up(void **state)
{
    static const struct {
        uint32_t bits;
        uint32_t baud;
        dg_ns ns;
    } rows[] = {
        {0, 9600, 0},
        {1, 1000000000, 1},
        {11, 9600, 1145834},
        {22, 9600, 2291667},
        {55, 9600, 5729167},
        {11, 38400, 286459},
        {55, 19200, 2864584},
        {1, 10000000, 100},
        {3, 10000000, 300},
        {1, 9999999, 101},
        {65535, 1, 65535000000000},
        {65535, 3, 21845000000000},
        {1, 1, 1000000000},
        {UINT32_MAX, 1, 4294967295000000000},
        {UINT32_MAX, UINT32_MAX, 1000000000},
        {11, 0, DG_NEVER},
        {0, 0, DG_NEVER},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_true(dg_bit_times_ns(rows[i].bits, rows[i].baud) == rows[i].ns);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spans_are_nanoseconds),
        cmocka_unit_test(after_saturates),
        cmocka_unit_test(elapsed_never_runs_backwards),
        cmocka_unit_test(earliest_of_two),
        cmocka_unit_test(spans_are_divided),
        cmocka_unit_test(bit_times_round_up),
    };

    return cmocka_run_group_tests_name("time", tests, NULL, NULL);
}
