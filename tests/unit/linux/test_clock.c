/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "clock.h"
#include "timer.h"

/* Real time of rig time: by hand from real + (at - virtual) * 1000 / permille, rounded up. */
static void real_time_of_a_deadline(void **state)
{
    static const struct {
        struct lx_clock clock;
        dg_ns at;
        dg_ns real;
    } rows[] = {
        {{1000, 1000, 1000}, 5000, 5000},
        {{1000, 1000, 1000}, 1000, 1000},
        {{1000, 1000, 1000}, 10, 1000}, /* long since: not before it was set */
        {{1000, 1000, 1000}, DG_NEVER, DG_NEVER},
        {{1000, 50, 500}, 60, 1020},   /* half as fast */
        {{1000, 50, 3000}, 60, 1004},  /* 3.33 rounded up */
        {{1000, 50, 3000}, 53, 1001},  /* exactly 1 */
        {{1000, 50, 1}, 51, 2000},     /* 1000 times slower */
        {{1000, 50, 0}, 51, DG_NEVER}, /* stands still */
        {{1000, 50, 0}, 50, 1000},
        {{1000, 50, 1}, DG_NEVER / 2, DG_NEVER}, /* beyond 64 bits */
        {{0, 0, UINT32_MAX}, UINT32_MAX, 1000},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_true(lx_clock_real(&rows[i].clock, rows[i].at) == rows[i].real);
    }
}

/* Between two readings of the real clock, what goes by is that time at the rate. */
static void time_goes_at_its_rate(void **state)
{
    static const uint32_t rates[] = {0, 1, 500, 1000, 10000};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rates); i++) {
        const dg_ns start = lx_now();
        const struct lx_clock clock = {.real = start, .virtual_ = 77, .permille = rates[i]};
        const dg_ns low = lx_now() - start;
        const dg_ns now = lx_clock_now(&clock) - 77;
        const dg_ns high = lx_now() - start;
        assert_in_range(now, low * rates[i] / 1000, high * rates[i] / 1000);
    }
}

/* As real time goes and set in real time, it is real time. */
static void unscaled_is_real(void **state)
{
    const dg_ns start = lx_now();
    const struct lx_clock clock = {.real = start, .virtual_ = start, .permille = 1000};
    (void)state;
    const dg_ns before = lx_now();
    const dg_ns now = lx_clock_now(&clock);
    assert_in_range(now, before, lx_now());
}

/* Set in the future, it has not begun. */
static void before_it_was_set(void **state)
{
    const struct lx_clock clock = {
        .real = lx_now() + DG_S(3600), .virtual_ = 5, .permille = 1000000};
    (void)state;
    assert_true(lx_clock_now(&clock) == 5);
}

/* Never early: at the real time of a deadline the rig's time has reached it. */
static void deadlines_are_not_early(void **state)
{
    (void)state;
    for (uint32_t permille = 1; permille < 5000; permille += 7) {
        for (dg_ns span = 1; span < 40; span++) {
            const struct lx_clock clock = {.real = 0, .virtual_ = 0, .permille = permille};
            const dg_ns real = lx_clock_real(&clock, span);
            assert_true(real * permille / 1000 >= span);
            assert_true((real - 1) * permille / 1000 < span);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(real_time_of_a_deadline), cmocka_unit_test(time_goes_at_its_rate),
        cmocka_unit_test(unscaled_is_real),        cmocka_unit_test(before_it_was_set),
        cmocka_unit_test(deadlines_are_not_early),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
