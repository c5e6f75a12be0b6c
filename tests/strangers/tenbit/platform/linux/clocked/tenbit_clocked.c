/* SPDX-License-Identifier: MIT */
/* What a plan knows of it. */

#include "clocked.h"
#include "drehgeber/tenbit.h"
#include "stacks.h"
#include "trace_format.h"

static int check(const struct lx_bus_setup *setup, const struct lx_station *station,
                 enum lx_clocked_master master, struct lx_error *error)
{
    const char *name = station->plan->model->name;
    (void)setup;
    return master == LX_CLOCKED_HERE ? 0
                                     : lx_refuse(error, "expected sim",
                                                 "%s has no time for a master in user space", name);
}

static const struct lx_clocked_protocol protocol = {
    .clock = "CLOCK",
    .data = "DATA",
    .master = &dg_tenbit_master,
    .check = check,
};

static const struct lx_trace_format vcd = LX_TRACE_CLOCKED("tenbit", "CLOCK", "DATA");

const struct lx_stack lx_tenbit_stack = {
    .core = &dg_tenbit_stack,
    .handle = &dg_tenbit_wire,
    .trace = &(const struct lx_trace_kind){"ten bits", {&vcd}, false},
    .clocked = &protocol,
    .wire = "sim",
};
