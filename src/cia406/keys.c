/* SPDX-License-Identifier: MIT */
/*
 * What can be set of an F36x8 before it is made.
 */
#include "drehgeber/cia406.h"

#define SERIAL_DEFAULT 1234567890u
#define TURNS 4096u
#define TURNS_WIDE 65536u

static const char *const turns_bits[2] = {"12", "16"};

#define AT(field) offsetof(struct dg_cia406_settings, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name     unit offset      type         places factor min                max  words       help */
    {"node",    "", AT(node),   DG_KEY_U32,  0, 1, 1, DG_CIA406_NODE_MAX, NULL,       "node-ID of a new EEPROM"},
    {"serial",  "", AT(serial), DG_KEY_U32,  0, 1, 0,         UINT32_MAX, NULL,       "serial number of a new EEPROM"},
    {"mt_bits", "", AT(wide),   DG_KEY_FLAG, 0, 1, 0,                  1, turns_bits, "bits of the turns"},
};
/* clang-format on */
#define ROW_MT_BITS 2u

const struct dg_keys dg_cia406_keys = {rows, DG_COUNT(rows)};

uint32_t dg_cia406_without(const struct dg_cia406_model *model)
{
    return model->turns == 1 || model->device->whole ? 1u << ROW_MT_BITS : 0;
}

void dg_cia406_settings_init(struct dg_cia406_settings *self, const struct dg_cia406_model *model)
{
    *self = (struct dg_cia406_settings){
        .model = *model,
        .serial = SERIAL_DEFAULT,
        .node = DG_CIA406_NODE_DEFAULT,
        .wide = model->turns == TURNS_WIDE,
    };
    if (model->device->whole) {
        const struct dg_co_file *file = (const struct dg_co_file *)(const void *)model->device;
        self->serial = file->serial != 0 ? file->serial : self->serial;
        self->node = file->node_id != 0 ? file->node_id : self->node;
    }
}

void dg_cia406_settings_apply(struct dg_cia406_settings *self)
{
    if (self->model.device != NULL && self->model.device->whole) {
        return;
    }
    if (self->model.turns == 1) {
        self->model.device = &dg_cia406_singleturn;
        return;
    }
    self->model.turns = self->wide ? TURNS_WIDE : TURNS;
    self->model.device = self->wide ? &dg_cia406_multiturn_32 : &dg_cia406_multiturn;
}
