/* SPDX-License-Identifier: MIT */
/* Bit times of CAN frames, and the load they make, in virtual time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/bus_frames.h"

#define T0 DG_S(1000)

static uint32_t bits_of(uint8_t dlc, bool rtr)
{
    const struct dg_can_frame frame = {.dlc = dlc, .rtr = rtr};
    return DG_CAN_BITS(1u, dg_can_bytes(&frame));
}

/* SOF to the end of the pause without stuff bits, 47 + 8n or 67 + 8n, and one bit behind four of
   the 34 + 8n or 54 + 8n that are stuffed, but for the first. */
static void frames_with_most_stuff_bits(void **state)
{
    (void)state;
    for (uint8_t n = 0; n <= 8; n++) {
        assert_int_equal(bits_of(n, false), 47 + 8 * n + (34 + 8 * n - 1) / 4);
        assert_int_equal(DG_CAN_EXTENDED_BITS(1u, n), 67u + 8u * n + (54u + 8u * n - 1u) / 4u);
    }
    assert_int_equal(bits_of(8, false), 135);
    assert_int_equal(bits_of(8, true), 55); /* without data, whatever its length says */
    assert_int_equal(DG_CAN_BITS(3, 12), bits_of(8, false) + bits_of(4, false) + bits_of(0, false));
    /* Chapter 8: a PDO fits the shortest event timers. */
    assert_true(dg_bit_times_ns(bits_of(8, false), 10000) < DG_MS(14));
    assert_true(dg_bit_times_ns(bits_of(8, false), 20000) < DG_MS(10));
    assert_true(dg_bit_times_ns(bits_of(8, false), 50000) < DG_MS(4));
}

static void load_of_a_window(void **state)
{
    struct dg_bus_load load;
    (void)state;
    dg_bus_load_begin(&load, T0, 700);
    assert_false(dg_bus_load_due(&load, T0 + DG_S(1) - 1));
    assert_int_equal(dg_bus_load_permille(&load, T0 + DG_S(1) - 1, 9000, 10000), 0);
    assert_true(dg_bus_load_due(&load, T0 + DG_S(1)));
    assert_false(dg_bus_load_close(&load, T0 + DG_S(1), 700 + 2500, 10000));
    assert_int_equal(load.permille, 250);
    /* In the next one nothing has been seen of it so far. */
    assert_false(dg_bus_load_due(&load, T0 + DG_S(2) - 1));
    assert_int_equal(dg_bus_load_permille(&load, T0 + DG_S(2) - 1, 99999, 10000), 250);
    /* One that nobody has ended is looked at as it is. */
    assert_int_equal(dg_bus_load_permille(&load, T0 + DG_S(3), 3200 + 10000, 10000), 500);
    assert_false(dg_bus_load_close(&load, T0 + DG_S(3), 3200 + 10000, 10000));
    assert_int_equal(load.permille, 500);
}

static void an_overload_begins_once(void **state)
{
    static const struct {
        uint64_t bits; /* in this second, at 10 kBd */
        bool begins;
    } rows[] = {
        {10400, false}, {10410, true}, {20000, false}, {10000, false},
        {10410, false}, {9010, false}, {10410, false}, {9000, false},
        {10400, false}, {10410, true}, {0, false},     {94000, true},
    };
    struct dg_bus_load load;
    uint64_t bits = 0;
    (void)state;
    dg_bus_load_begin(&load, T0, bits);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        bits += rows[i].bits;
        assert_int_equal(dg_bus_load_close(&load, T0 + DG_S(i + 1), bits, 10000), rows[i].begins);
        assert_int_equal(load.permille, rows[i].bits / 10);
    }
}

static void loads_that_are_none(void **state)
{
    struct dg_bus_load load;
    (void)state;
    dg_bus_load_begin(&load, T0, 5000);
    assert_false(dg_bus_load_close(&load, T0 + DG_S(1), 9000, 0)); /* no bit rate */
    assert_int_equal(load.permille, 0);
    assert_false(dg_bus_load_close(&load, T0 + DG_S(2), 10, 100)); /* another interface */
    assert_int_equal(load.permille, 0);
    assert_false(dg_bus_load_close(&load, T0 + DG_S(3), 1010, 10000));
    assert_int_equal(load.permille, 100);
    /* A clock that stands still, a bus that nobody has looked at for a year, at 1 MBd. */
    assert_false(dg_bus_load_close(&load, T0 + DG_S(3), 2010, 10000));
    assert_int_equal(load.permille, 0);
    const dg_ns year = DG_S(31536000);
    assert_false(
        dg_bus_load_close(&load, T0 + DG_S(3) + year, 2010 + UINT64_C(15768000000000), 1000000));
    assert_int_equal(load.permille, 500);
    assert_true(dg_bus_load_close(&load, T0 + DG_S(4) + year, UINT64_MAX / 1000u, 1));
    assert_int_equal(load.permille, UINT32_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_with_most_stuff_bits),
        cmocka_unit_test(load_of_a_window),
        cmocka_unit_test(an_overload_begins_once),
        cmocka_unit_test(loads_that_are_none),
    };
    return cmocka_run_group_tests_name("load of a CAN bus", tests, NULL, NULL);
}
