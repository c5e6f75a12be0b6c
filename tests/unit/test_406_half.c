/* SPDX-License-Identifier: MIT */
/*
 * Universal scaling function (chapter 22; C26): which way the shaft went while the power was off.
 * Of what a multiturn tells, half the range is one way and half is the other.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "co_rig.h"

#define STEPS ((int64_t)DG_CIA406_STEPS)
#define HALF (4096 / 2 * STEPS)

static struct co_rig rig;

static void turn_to(int64_t counts)
{
    rig.motion.from = dg_angle_of_counts(counts, DG_CIA406_STEPS);
}

/* 16 units a turn, 1000 of them: 2048 turns are 32768 units, 768 and whole ranges. */
static void half_the_range_is_told_from_the_other(void **state)
{
    static const struct {
        int64_t way;
        uint32_t position;
    } rows[] = {
        {0, 0}, {STEPS / 16, 1}, {-1, 999}, {-STEPS / 16, 999}, {HALF - 1, 767}, {-HALF, 232},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        co_rig_start(&rig);
        turn_to(0);
        co_rig_put(&rig, 0x6001, 0, 16, 4);
        co_rig_put(&rig, 0x6002, 0, 1000, 4);
        co_rig_put(&rig, 0x6000, 0, 0x1004, 2); /* USF, scaling */
        co_rig_put(&rig, 0x6003, 0, 0, 4);
        co_rig_put(&rig, 0x1010, 1, 0x65766173, 4);
        dg_co_power_off(&rig.node);
        turn_to(rows[i].way);
        assert_int_equal(co_rig_power_on(&rig), DG_OK);
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), rows[i].position);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(half_the_range_is_told_from_the_other)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
