/* SPDX-License-Identifier: MIT */
#include "modbus_settings.h"
#include "trace_format.h"

#include <stddef.h>

#define OF_RING(field) offsetof(struct lx_ring_settings, field)

/* clang-format off */
static const struct dg_key ring_keys[] = {
    /* name                 unit      offset                        type       places factor min   max                words      help */
    {"cycle",              "us",     OF_RING(cycle_us),            DG_KEY_U32,  0, 1,       250, 50000,              NULL,      "from one data cycle of the ring to the next"},
    {"tear",               "",       OF_RING(tear),                DG_KEY_FLAG, 0, 1,       0,   1,                  dg_key_no_yes, "1: half of an OUT word is taken from a request (fault)"},
    {"break_at",           "",       OF_RING(break_at),            DG_KEY_U16,  0, 1,       0,   DG_RING_MAX - 1, NULL,      "the bus is cut before this device, 0 is the first (fault)"},
};
/* clang-format on */

const struct dg_keys lx_ring_keys = {
    .rows = ring_keys,
    .count = DG_COUNT(ring_keys),
};

const struct lx_ring_settings lx_ring_defaults = {
    .cycle_us = 1000,
    .break_at = DG_RING_WHOLE,
};

static void defaults(void *settings, const struct dg_device *device)
{
    *(struct dg_ib_model *)settings = *dg_ib_model_of(device);
}

static const char title[] = "INTERBUS";
static const struct lx_trace_format *const formats[] = {&lx_trace_csv, NULL};
static const struct lx_trace_kind trace = {title, formats, false};

const struct lx_stack lx_ib_stack = {
    .core = &dg_ib_stack,
    .title = title,
    .trace = &trace,
    .words = &dg_ib_words,
    .wire = "modbus",
    .is_ring = true,
    .keys = &dg_ib_keys,
    .blind = DG_IB_BLIND,
    .settings_size = sizeof(struct dg_ib_model),
    .defaults = defaults,
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
