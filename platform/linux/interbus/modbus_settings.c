/* SPDX-License-Identifier: MIT */
#include "modbus_settings.h"
#include "trace_format.h"

const struct lx_stack lx_ib_stack = {
    .core = &dg_ib_stack,
    .handle = &dg_ib_wire,
    .trace = &(const struct lx_trace_kind){"INTERBUS", {&lx_trace_csv}, false},
    .wire = "modbus",
    .spoiled = "the encoder answers 86000000h",
    .is_ring = true,
};
