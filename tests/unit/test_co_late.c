/* SPDX-License-Identifier: MIT */
/* A host that is late every time: heartbeat producer and event timers keep their period. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "co_rig.h"

#define HEARTBEAT 0x73F
#define TPDO1 0x1BF
#define START 0x01
#define PERIOD DG_MS(10)
#define FRAMES 100u

static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    return 0;
}

/* Every deadline is served so late, for this many frames. */
static void run_late(dg_ns late, uint32_t frames)
{
    dg_ns next = dg_co_step(&rig.node, rig.now);
    co_rig_forget(&rig);
    while (rig.count < frames) {
        assert_true(next != DG_NEVER && next > rig.now);
        rig.now = next + late;
        next = dg_co_step(&rig.node, rig.now);
    }
}

static void expect_period(uint16_t id, dg_ns first, dg_ns period)
{
    for (uint32_t i = 0; i < FRAMES; i++) {
        assert_int_equal(rig.frame[i].id, id);
        assert_int_equal(rig.at[i], first + i * period);
    }
}

static void a_heartbeat_keeps_its_period(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x1017, 0, 10, 2);
    const dg_ns begin = rig.now;
    run_late(DG_MS(1), FRAMES);
    expect_period(HEARTBEAT, begin + PERIOD + DG_MS(1), PERIOD);
}

static void an_event_timer_keeps_its_period(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x1800, 5, 10, 2);
    co_rig_put(&rig, 0x1802, 1, 0x800003BF, 4);
    co_rig_put(&rig, 0x1803, 1, 0x800004BF, 4);
    co_rig_nmt(&rig, START);
    const dg_ns begin = rig.now;
    run_late(DG_MS(1), FRAMES);
    expect_period(TPDO1, begin + PERIOD + DG_MS(1), PERIOD);
}

/* What is late by a period or more is one frame, and the next one comes a period later. */
static void whole_periods_are_not_made_up_for(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x1017, 0, 10, 2);
    const dg_ns begin = rig.now;
    run_late(DG_MS(25), FRAMES);
    expect_period(HEARTBEAT, begin + PERIOD + DG_MS(25), PERIOD + DG_MS(25));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_heartbeat_keeps_its_period, setup),
        cmocka_unit_test_setup(an_event_timer_keeps_its_period, setup),
        cmocka_unit_test_setup(whole_periods_are_not_made_up_for, setup),
    };
    return cmocka_run_group_tests_name("a host that is late", tests, NULL, NULL);
}
