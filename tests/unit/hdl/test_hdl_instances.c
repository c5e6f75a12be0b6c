/* SPDX-License-Identifier: MIT */
/*
 * Encoders for simulators as a simulator's language has them: by number, with a name, steered and
 * looked at by numbers.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hdl_names.h"

static void instances_have_names(void **state)
{
    const int32_t one = dg_hdl_make("one", "ssi-25", "", "90DEG", "");
    const int32_t two = dg_hdl_make("two", "s3684-rs485", "", "", "");

    (void)state;
    assert_int_equal(dg_hdl_make("two", "ssi-25", "", "", ""), -2);
    assert_int_equal(dg_hdl_find("one"), one);
    assert_int_equal(dg_hdl_find("two"), two);
    assert_int_equal(dg_hdl_find("three"), -1);
    assert_int_equal(dg_hdl_steer(one, 1, 0, DG_HDL_TURN, "", 0.5), 0);
    assert_int_equal(dg_hdl_steer(one, 1, 0, DG_HDL_COMMAND, "SHAFt:POSition?", 0.0), 0);
    assert_int_equal(dg_hdl_character(one, DG_HDL_ANSWER, 0), '1');
    assert_int_equal(dg_hdl_character(one, DG_HDL_ANSWER, 10), 0);
    assert_int_equal(dg_hdl_character(one, DG_HDL_NOTE, 2), 'e');
    assert_int_equal(dg_hdl_character(one, DG_HDL_NOTE, 3), ':');
    assert_true(dg_hdl_steer(two, 1, 0, DG_HDL_FAULT, "fire", 1.0) < 0);
    assert_int_equal(dg_hdl_character(two, 1, 0), 'f');
    assert_int_equal(dg_hdl_rest(two, 1, 0, 1000), 1000);
    assert_true(dg_hdl_real(two, 1, 0, DG_HDL_COSINE) != 0.0);
    dg_hdl_make_none();
}

/* A turn of 0.5 in ST of 12 bits, then 60000 RPM for 250 us: a quarter of a turn. */
static void instances_are_steered_and_looked_at(void **state)
{
    const int32_t id = dg_hdl_make("one", "s3674-biss", "st=12", "", "");

    (void)state;
    assert_true(dg_hdl_real(id, 0, 0, DG_HDL_LATCHED) == -1.0);
    assert_true(dg_hdl_real(id, 0, 0, DG_HDL_LATCHED_AT_US) < 0.0);
    assert_int_equal(dg_hdl_steer(id, 1, 0, DG_HDL_TURN, "", 0.5), 0);
    assert_true(dg_hdl_real(id, 1, 0, DG_HDL_POSITION) == 2048.0);
    assert_int_equal(dg_hdl_steer(id, 1, 0, DG_HDL_SPEED, "", 60000.0), 0);
    assert_true(dg_hdl_real(id, 251, 0, DG_HDL_POSITION) == 3072.0);
    assert_int_equal(dg_hdl_steer(id, 252, 0, DG_HDL_MOTION, "45DEG", 0.0), 0);
    assert_true(dg_hdl_real(id, 252, 1, DG_HDL_POSITION) == 512.0);
    assert_int_equal(dg_hdl_steer(id, 253, 0, DG_HDL_WORLD, "temperature", 41.5), 0);
    assert_int_equal(dg_hdl_steer(id, 253, 0, DG_HDL_COMMAND, "WORLd:TEMPerature?", 0.0), 0);
    assert_int_equal(dg_hdl_character(id, DG_HDL_ANSWER, 0), '4');
    assert_int_equal(dg_hdl_character(id, DG_HDL_ANSWER, 1), '1');
    assert_int_equal(dg_hdl_steer(id, 254, 0, DG_HDL_POWER, "", 0.0), 0);
    assert_int_equal(dg_hdl_steer(id, 254, 0, DG_HDL_COMMAND, "POWer?", 0.0), 0);
    assert_int_equal(dg_hdl_character(id, DG_HDL_ANSWER, 0), '0');
    assert_true(dg_hdl_steer(id, 255, 0, DG_HDL_COMMAND + 1, "", 0.0) < 0);
    dg_hdl_make_none();
}

/* 2048 periods in a turn of 1 V from peak to peak: at 0 the cosine has its peak, a quarter of a
 * period on the sine. */
static void volts_are_looked_at_by_number(void **state)
{
    const int32_t id = dg_hdl_make("one", "s3684-rs485", "", "", "");

    (void)state;
    assert_float_equal(dg_hdl_real(id, 1, 0, DG_HDL_SINE), 0.0, 0.01);
    assert_float_equal(dg_hdl_real(id, 1, 0, DG_HDL_COSINE), 0.5, 0.01);
    assert_int_equal(dg_hdl_steer(id, 1, 0, DG_HDL_TURN, "", 1.0 / 8192.0), 0);
    assert_float_equal(dg_hdl_real(id, 2, 0, DG_HDL_SINE), 0.5, 0.01);
    assert_float_equal(dg_hdl_real(id, 2, 0, DG_HDL_COSINE), 0.0, 0.01);
    assert_true(dg_hdl_real(id, 2, 0, DG_HDL_COSINE + 1) == 0.0);
    dg_hdl_make_none();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(instances_have_names),
        cmocka_unit_test(instances_are_steered_and_looked_at),
        cmocka_unit_test(volts_are_looked_at_by_number),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
