/* SPDX-License-Identifier: MIT */
#include "stacks.h"
#include "trace_format.h"

const struct lx_stack lx_eleven_stack = {
    .core = &dg_eleven_stack,
    .handle = &dg_eleven_wire,
    .trace = &(const struct lx_trace_kind){"eleven characters", {&lx_trace_uart}, false},
    .wire = "pty",
    .baud = DG_ELEVEN_BAUD,
};
