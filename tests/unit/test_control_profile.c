/* SPDX-License-Identifier: MIT */
/* A profile that the host reads in parts: the session waits, the shaft turns once it is read. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "control_rig.h"

static struct control_rig rig;

static int setup(void **state)
{
    (void)state;
    control_rig_start(&rig);
    return 0;
}

/* A host that is told of a shaft before and after it turns otherwise, and reads a profile in parts.
 */
static struct {
    unsigned before;
    unsigned after;
    unsigned parts;
    bool gone;
} told;

static void before_it_turns(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now)
{
    (void)self;
    (void)now;
    assert_ptr_equal(shaft, &rig.shaft[0]);
    told.before++;
}

static void it_has_turned(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now)
{
    (void)self;
    (void)now;
    assert_ptr_equal(shaft, &rig.shaft[0]);
    told.after++;
    assert_true(told.before >= told.after);
}

static int read_a_part(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now, bool gone,
                       char *detail)
{
    (void)self;
    (void)now;
    assert_ptr_equal(shaft, &rig.shaft[0]);
    assert_string_equal(detail, "");
    told.gone = gone;
    return --told.parts > 0 ? DG_RIG_READS : rig.result;
}

static void read_in_parts(int result)
{
    memset(&told, 0, sizeof told);
    rig.ops.turns = before_it_turns;
    rig.ops.turned = it_has_turned;
    rig.ops.profile_more = read_a_part;
    rig.result = DG_RIG_READS;
    assert_string_equal(control_rig_say(&rig, "SHAF:PROF \"long.csv\";:SHAF:MOV?"), "");
    assert_int_equal(told.after, 0);
    told.parts = 3;
    rig.result = result;
}

static void test_profile_in_parts(void **state)
{
    (void)state;
    read_in_parts(DG_SCPI_NO_ERROR);
    assert_int_equal(dg_control_step(&rig.control, rig.now), rig.now);
    assert_int_equal(dg_control_step(&rig.control, rig.now), rig.now);
    assert_string_equal(rig.answer, ""); /* what stands behind it waits */
    assert_int_equal(dg_control_step(&rig.control, rig.now), DG_NEVER);
    assert_string_equal(rig.answer, "0\n");
    assert_int_equal(told.after, 1);
    assert_int_equal(rig.changes, 0); /* turned() in its place */

    read_in_parts(DG_SCPI_ILLEGAL);
    told.parts = 1;
    assert_int_equal(dg_control_step(&rig.control, rig.now), DG_NEVER);
    assert_int_equal(told.after, 0);
    assert_string_equal(control_rig_say(&rig, "SYST:ERR?"), "-224,\"Illegal parameter value\"");
}

static void test_profile_given_up(void **state)
{
    (void)state;
    read_in_parts(DG_SCPI_NO_ERROR);
    dg_scpi_leave(&rig.control.session);
    assert_true(told.gone);
    assert_int_equal(told.after, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_profile_in_parts, setup),
        cmocka_unit_test_setup(test_profile_given_up, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
