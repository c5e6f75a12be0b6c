/* SPDX-License-Identifier: MIT */
/*
 * What the EDS files of the F36x8 say beside their dictionary: names, mostly. No device points
 * here, so that firmware which prints no EDS does not carry it.
 */
#include "drehgeber/cia406.h"

#define DG_CO_PARENT(index, kind, name) {(uint16_t)(index), 0, DG_CO_##kind, name},
#define DG_CO_MORE(index, sub, name) {(uint16_t)(index), sub, DG_CO_VAR, name},
#define DG_CO_OBJECT(index, sub, more, type, access, slot, initial, limits, hook, name)            \
    DG_CO_MORE(index, sub, name)

static const struct dg_co_name names[] = {
#include "objects.def"
};

#define F36X8 .vendor = "Kuebler", .names = names, .name_count = DG_COUNT(names)

static const struct dg_co_sheet sheets[] = {
    {
        F36X8,
        .device = &dg_cia406_singleturn,
        .model = "f3658",
        .resolution = "65536 steps, singleturn",
    },
    {
        F36X8,
        .device = &dg_cia406_multiturn,
        .model = "f3668",
        .resolution = "65536 steps, 4096 turns",
    },
    {
        F36X8,
        .device = &dg_cia406_multiturn_32,
        .model = "f3668",
        .resolution = "65536 steps, 65536 turns",
    },
};

const struct dg_co_sheet *dg_cia406_sheet(const struct dg_co_device *device)
{
    for (size_t i = 0; i < DG_COUNT(sheets); i++) {
        if (sheets[i].device == device) {
            return &sheets[i];
        }
    }
    return NULL;
}

const struct dg_co_sheet *dg_cia406_sheet_of(const struct dg_device *model)
{
    const struct dg_cia406_model *figures = dg_cia406_model_of(model);

    return figures != NULL ? dg_cia406_sheet(figures->device) : NULL;
}
