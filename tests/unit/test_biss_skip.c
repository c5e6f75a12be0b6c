/* SPDX-License-Identifier: MIT */
/* Frames that nobody looks at leave behind what they would have left behind. */
#include "biss_rig.h"
#include "drehgeber/devices.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static struct biss_rig rig[2];

static int setup(void **state)
{
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(biss_rig_init(&rig[i], dg_biss_model_of(dg_device_find("s3684-biss")), 1),
                         DG_OK);
        assert_int_equal(dg_biss_power_on(&rig[i].slave[0], 0), DG_OK);
    }
    return 0;
}

static void read_frame(struct dg_biss *device, bool cdm)
{
    uint64_t bits;
    assert_true(dg_biss_frame(device, DG_S(1), &bits) > 0);
    dg_biss_frame_end(device, DG_S(1), cdm);
}

static void skip_and_compare(uint64_t n)
{
    struct dg_biss *clocked = &rig[0].slave[0];
    struct dg_biss *skipped = &rig[1].slave[0];
    for (uint64_t i = 0; i < n; i++) {
        read_frame(clocked, false);
    }
    dg_biss_skip(skipped, n);
    assert_int_equal(skipped->life, clocked->life);
    assert_int_equal(skipped->started, clocked->started);
    assert_int_equal(skipped->noise, clocked->noise);
    assert_int_equal(skipped->counters.frames, clocked->counters.frames);
    assert_int_equal(skipped->control.state, clocked->control.state);
    assert_int_equal(skipped->control.zeros, clocked->control.zeros);
    assert_int_equal(skipped->control.cds, clocked->control.cds);
}

static void from_the_start_on(void **state)
{
    (void)state;
    for (uint64_t n = 0; n < 200; n++) {
        assert_int_equal(setup(NULL), 0);
        skip_and_compare(n);
        skip_and_compare(n % 7);
    }
}

static void for_days(void **state)
{
    (void)state;
    skip_and_compare(1000003);
    skip_and_compare(62);
}

static void inside_a_control_frame(void **state)
{
    (void)state;
    for (uint64_t n = 0; n < 40; n++) {
        assert_int_equal(setup(NULL), 0);
        skip_and_compare(20);
        for (unsigned bit = 0; bit < 12; bit++) {
            read_frame(&rig[0].slave[0], bit % 3 != 1);
            read_frame(&rig[1].slave[0], bit % 3 != 1);
        }
        skip_and_compare(n);
    }
}

static void without_power_there_are_none(void **state)
{
    (void)state;
    struct dg_biss *device = &rig[0].slave[0];
    dg_biss_power_off(device);
    const struct dg_biss before = *device;
    dg_biss_skip(device, 5);
    assert_memory_equal(device, &before, sizeof before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(from_the_start_on, setup),
        cmocka_unit_test_setup(for_days, setup),
        cmocka_unit_test_setup(inside_a_control_frame, setup),
        cmocka_unit_test_setup(without_power_there_are_none, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
