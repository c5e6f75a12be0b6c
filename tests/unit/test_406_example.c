/* SPDX-License-Identifier: MIT */
/* The application example of the manual's chapters 11 and 12, from end to end in virtual time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "co_rig.h"

#define TPDO1 0x1BF
#define TPDO2 0x2BF
#define HEARTBEAT 0x73F
#define START 0x01
#define SAVE 0x65766173u

static struct co_rig rig;

static void configure(void)
{
    co_rig_put(&rig, 0x6002, 0, 36000, 4);
    co_rig_put(&rig, 0x6001, 0, 3600, 4);
    co_rig_put(&rig, 0x6000, 0, 0x0004, 2);
    co_rig_put(&rig, 0x6003, 0, 0, 4);
    co_rig_put(&rig, 0x1800, 2, 255, 1);
    co_rig_put(&rig, 0x1800, 5, 10, 2);
    /* the five steps of a mapping change */
    co_rig_put(&rig, 0x1801, 1, 0x800002BF, 4);
    co_rig_put(&rig, 0x1A01, 0, 0, 1);
    co_rig_put(&rig, 0x1A01, 1, 0x60300110, 4);
    co_rig_put(&rig, 0x1A01, 0, 1, 1);
    co_rig_put(&rig, 0x1801, 2, 255, 1);
    co_rig_put(&rig, 0x1801, 5, 20, 2);
    co_rig_put(&rig, 0x1801, 1, 0x000002BF, 4);
    co_rig_put(&rig, 0x1017, 0, 500, 2);
    co_rig_put(&rig, 0x6401, 1, 1000, 4);
    co_rig_put(&rig, 0x6402, 1, 35000, 4);
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
}

/* Frames of `id`, `period` apart. */
static void expect_every(uint16_t id, dg_ns period, uint32_t count)
{
    uint32_t found = 0;
    dg_ns last = 0;

    for (uint32_t i = 0; i < rig.count; i++) {
        if (rig.frame[i].id != id) {
            continue;
        }
        assert_true(found == 0 || rig.at[i] - last == period);
        last = rig.at[i];
        found++;
    }
    assert_int_equal(found, count);
}

static const struct dg_can_frame *newest(uint16_t id)
{
    for (uint32_t i = rig.count; i > 0; i--) {
        if (rig.frame[i - 1].id == id) {
            return &rig.frame[i - 1];
        }
    }
    fail_msg("no frame with CAN-ID %Xh", id);
    return NULL;
}

/* 60 rpm from position 0: 36 units in 10 ms. */
static void expect_a_second_of_operation(void)
{
    co_rig_nmt(&rig, START);
    rig.motion.kind = DG_MOTION_SPEED;
    rig.motion.start = rig.now;
    rig.motion.mrpm = 60000;
    co_rig_forget(&rig);
    co_rig_run(&rig, DG_S(1));
    assert_true(rig.count <= CO_RIG_FRAMES);
    expect_every(TPDO1, DG_MS(10), 100);
    expect_every(TPDO2, DG_MS(20), 50);
    expect_every(HEARTBEAT, DG_MS(500), 2);
    assert_int_equal(rig.count, 152);
    assert_int_equal(newest(TPDO1)->dlc, 4);
    assert_memory_equal(newest(TPDO1)->data, "\x10\x0E\x00\x00", 4); /* 3600 */
    assert_int_equal(newest(TPDO2)->dlc, 2);
    /* 6553.6 counts in 100 ms: 59 or 60 rpm */
    assert_in_range(newest(TPDO2)->data[0], 59, 60);
    assert_int_equal(newest(HEARTBEAT)->data[0], 0x05);
}

static void expect_the_work_area(void)
{
    static const struct {
        int64_t position;
        uint32_t bits;
    } rows[] = {{999, 5}, {1000, 0}, {35000, 0}, {35001, 3}};

    rig.motion = (struct dg_motion){0};
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        rig.motion.from = dg_angle_of_counts(rows[i].position, 3600);
        rig.motion.from += DG_TURN / 7200; /* in the middle of the unit */
        assert_int_equal(co_rig_get(&rig, 0x6004, 0), rows[i].position);
        assert_int_equal(co_rig_get(&rig, 0x6400, 1), rows[i].bits);
    }
    rig.motion.from = 0;
}

static void expect_the_example(void)
{
    configure();
    for (int i = 0; i < 2; i++) {
        co_rig_run(&rig, DG_S(1)); /* the speed of before is forgotten */
        expect_a_second_of_operation();
        expect_the_work_area();
        dg_co_power_off(&rig.node);
        co_rig_run(&rig, DG_S(1));
        assert_int_equal(co_rig_power_on(&rig), DG_OK);
    }
}

static void the_example_works_and_survives_power_off(void **state)
{
    (void)state;
    co_rig_start(&rig);
    expect_the_example();
}

/* Its low limit comes first, and is above the high one that was saved (C42). */
static void the_example_works_on_other_limits(void **state)
{
    (void)state;
    co_rig_start(&rig);
    co_rig_put(&rig, 0x6402, 1, 500, 4);
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    dg_co_power_off(&rig.node);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
    expect_the_example();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_example_works_and_survives_power_off),
        cmocka_unit_test(the_example_works_on_other_limits),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
