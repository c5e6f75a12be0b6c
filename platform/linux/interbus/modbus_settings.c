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

/* As one of a ring a K1 takes turns and leaves them. */
struct dg_ib_model lx_ib_settings_model(const struct dg_ib_model *settings, uint32_t index)
{
    struct dg_ib_model model = *settings;
    if (model.profile == DG_IB_K1) {
        model.turns = 1;
    }
    model.serial = (model.serial + index) & DG_IB_DATA_MASK;
    return model;
}
