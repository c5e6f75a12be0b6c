/* SPDX-License-Identifier: MIT */
#include "modbus_settings.h"
#include "trace_format.h"

#include <stddef.h>

#define OF_RING(field) offsetof(struct lx_ring_settings, field)
#define AT(field) offsetof(struct lx_ib_settings, field)

/* clang-format off */
static const struct dg_key ring_keys[] = {
    /* name                 unit      offset                        type       places factor min   max                words      help */
    {"cycle",              "us",     OF_RING(cycle_us),            DG_KEY_U32,  0, 1,       250, 50000,              NULL,      "from one data cycle of the ring to the next"},
    {"tear",               "",       OF_RING(tear),                DG_KEY_FLAG, 0, 1,       0,   1,                  dg_key_no_yes, "1: half of an OUT word is taken from a request (fault)"},
    {"break_at",           "",       OF_RING(break_at),            DG_KEY_U16,  0, 1,       0,   DG_IB_RING_MAX - 1, NULL,      "the bus is cut before this device, 0 is the first (fault)"},
};
static const struct dg_key keys[] = {
    {"steps",              "",       AT(model.steps),              DG_KEY_U16,  0, 1,       1,   8192,               NULL,      "steps of the discs a turn (factory)"},
    {"turns",              "",       AT(turns),                    DG_KEY_U16,  0, 1,       1,   4096,               NULL,      "turns of a K2 and K3; 1: singleturn (factory)"},
    {"steps_minus_one",    "",       AT(model.steps_minus_one),    DG_KEY_FLAG, 0, 1,       0,   1,                  dg_key_no_yes, "a K3 has one step more than its parameter says (factory)"},
    {"temperature_sensor", "",       AT(model.temperature_sensor), DG_KEY_FLAG, 0, 1,       0,   1,                  dg_key_no_yes, "a K3 has one (factory)"},
    {"loop",               "",       AT(model.loop),               DG_KEY_FLAG, 0, 1,       0,   1,                  dg_key_no_yes, "INTERBUS Loop: ID B2h and B3h (factory)"},
    {"param_cycles",       "cycles", AT(model.param_cycles),       DG_KEY_U8,   0, 1,       1,   255,                NULL,      "from a K3's command to its answer"},
    {"self_test_ms",       "ms",     AT(model.self_test),          DG_KEY_NS,   0, 1000000, 0,   1000,               NULL,      "self-test after power-on"},
    {"version",            "",       AT(model.version),            DG_KEY_U32,  0, 1,       0,   DG_IB_DATA_MASK,    NULL,      "software version of a K3 (factory)"},
};
static const struct dg_key serial =
    {"serial",             "",       AT(model.serial),             DG_KEY_U32,  0, 1,       0,   DG_IB_DATA_MASK,    NULL,      "serial number"};
/* clang-format on */

const struct lx_keys lx_ring_keys = {
    .rows = ring_keys,
    .count = DG_COUNT(ring_keys),
};

const struct lx_ring_settings lx_ring_defaults = {
    .cycle_us = 1000,
    .break_at = DG_IB_RING_WHOLE,
};

static void defaults(void *settings, const struct dg_device *device)
{
    *(struct lx_ib_settings *)settings = (struct lx_ib_settings){
        .model = *dg_ib_model_of(device),
        .turns = dg_ib_model_of(device)->turns,
    };
}

#define SENSED(id) (UINT32_C(1) << DG_QUANTITY_##id)
#define ALL ((UINT32_C(1) << DG_QUANTITY_COUNT) - 1u)

static const char title[] = "INTERBUS";
static const struct lx_trace_format *const formats[] = {&lx_trace_csv, NULL};
static const struct lx_trace_kind trace = {title, formats, false};

const struct lx_stack lx_ib_stack = {
    .core = &dg_ib_stack,
    .title = title,
    .trace = &trace,
    .wire = "modbus",
    .is_ring = true,
    .keys = keys,
    .key_count = DG_COUNT(keys),
    .serial = &serial,
    .blind = ALL & ~(SENSED(TEMPERATURE) | SENSED(SINGLETURN) | SENSED(MULTITURN_AMPLITUDE) |
                     SENSED(MULTITURN_SYNC) | SENSED(MULTITURN_VECTOR) | SENSED(EEPROM)),
    .settings_size = sizeof(struct lx_ib_settings),
    .defaults = defaults,
};

struct dg_ib_model lx_ib_settings_model(const struct lx_ib_settings *self, uint32_t index)
{
    struct dg_ib_model model = self->model;
    if (model.profile != DG_IB_K1) {
        model.turns = self->turns;
    }
    model.serial = (model.serial + index) & DG_IB_DATA_MASK;
    return model;
}
