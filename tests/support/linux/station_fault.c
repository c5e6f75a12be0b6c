/* SPDX-License-Identifier: MIT */
#include "station_fault.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include "drehgeber/instruments.h"
#include "timer.h"

static size_t entry_of(const struct dg_fault_target *target, enum dg_wire_fault fault)
{
    struct dg_fault_entry entry;
    for (size_t n = 0; dg_fault_entry(target, n, &entry); n++) {
        if (entry.kind == DG_FAULT_WIRE && entry.row->wire == fault) {
            return n;
        }
    }
    fail_msg("no entry for wire fault %d", (int)fault);
    return 0;
}

void station_bend(struct lx_station *station, const struct dg_stack *stack,
                  enum dg_wire_fault fault, uint32_t count)
{
    const struct dg_fault_target target = {.instrument = dg_instrument_of(stack),
                                           .world = &station->world};
    const struct dg_fault_limits limits = {count, 1000000, DG_NEVER};
    assert_int_equal(dg_fault_set(&station->control.faults, &target, entry_of(&target, fault),
                                  lx_now(), &limits),
                     DG_OK);
}

void station_mend(struct lx_station *station, const struct dg_stack *stack,
                  enum dg_wire_fault fault)
{
    const struct dg_fault_target target = {.instrument = dg_instrument_of(stack),
                                           .world = &station->world};
    assert_int_equal(dg_fault_clear(&station->control.faults, &target, entry_of(&target, fault)),
                     DG_OK);
}
