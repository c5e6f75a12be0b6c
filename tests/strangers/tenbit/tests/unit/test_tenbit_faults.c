/* SPDX-License-Identifier: MIT */
/*
 * What happens to the wire of an encoder with words of ten bits: its catalogue, row by row.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "drehgeber/control.h"
#include "drehgeber/tenbit.h"
#include "host_rig.h"

#define POSITION 0x2B5u
#define HALF 500u

static struct host_rig_place panel_place;

static unsigned word(struct dg_host *self, uint64_t at)
{
    unsigned bits = 0;

    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        (void)dg_host_clock(self, at, false);
        (void)dg_host_clock(self, at + HALF, true);
        (void)dg_host_step(self, at + 2u * HALF - 1u);
        bits = bits << 1 | (unsigned)dg_host_clock(self, at + 2u * HALF - 1u, true);
        at += 2u * HALF;
    }
    (void)dg_host_step(self, at + MS);
    return bits;
}

static void every_fault_is_seen_and_goes(void **state)
{
    static const struct {
        const char *name;
        unsigned flipped; /* of the bits, these may be; all else as it was */
        unsigned count;   /* so many are; 0: it does not matter */
    } rows[] = {
        {"wire_drop", POSITION, 6},
        {"wire_delay", DG_TENBIT_ALL, 0},
        {"wire_damage", DG_TENBIT_ALL, 1},
        {"wire_break", POSITION, 6},
    };
    struct dg_host *self = host_rig_start(&host_rig_here, "tenbit-low");
    uint64_t at = READY;

    (void)state;
    dg_host_shaft(self, at, (int64_t)POSITION * (TURN >> DG_TENBIT_BITS), 0);
    struct dg_host_panel *panel =
        dg_host_panel_make(panel_place.bytes, sizeof panel_place.bytes, self);
    assert_non_null(panel);
    assert_int_equal(dg_tenbit_instrument.fault_count, DG_COUNT(rows));
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_int_equal(word(self, at += SECOND), POSITION);
        assert_int_equal(dg_host_fault_set(panel, at += 2 * MS, rows[i].name, true), DG_HOST_OK);
        const unsigned flipped = word(self, at += SECOND) ^ POSITION;
        unsigned count = 0;
        for (unsigned bits = flipped; bits != 0; bits &= bits - 1u) {
            count++;
        }
        assert_int_not_equal(flipped, 0);
        assert_int_equal(flipped & ~rows[i].flipped, 0);
        assert_true(rows[i].count == 0 || count == rows[i].count);
        assert_int_equal(dg_host_fault_set(panel, at += 2 * MS, rows[i].name, false), DG_HOST_OK);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {cmocka_unit_test(every_fault_is_seen_and_goes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
