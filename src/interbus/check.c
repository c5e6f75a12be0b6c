/* SPDX-License-Identifier: MIT */
/*
 * States that somebody has made: what a device goes by, and whether it fits together.
 */
#include <string.h>

#include "interbus_private.h"

static const struct dg_stack_range ranges[] = {
    DG_STACK_RANGE(dg_ib, store.region_count, 0, DG_STORE_REGIONS_MAX),
    DG_STACK_BOOL(dg_ib, store.unapplied),
    DG_STACK_BOOL(dg_ib, powered),
    DG_STACK_BOOL(dg_ib, mounted),
    DG_STACK_BOOL(dg_ib, reconfigure),
    DG_STACK_BOOL(dg_ib, crc_error),
    DG_STACK_BOOL(dg_ib, outgoing_off),
    DG_STACK_BOOL(dg_ib, sampled),
    DG_STACK_BOOL(dg_ib, invalid),
    DG_STACK_BOOL(dg_ib, frozen),
    DG_STACK_BOOL(dg_ib, preset_flag),
    DG_STACK_RANGE(dg_ib, sent.steps, 0, DG_IB_DATA_MASK),
    DG_STACK_RANGE(dg_ib, sent.revolutions, 0, DG_IB_TURNS_MAX),
    DG_STACK_RANGE(dg_ib, steps, 0, DG_IB_DATA_MASK),
    DG_STACK_RANGE(dg_ib, revolutions, 0, DG_IB_TURNS_MAX),
    DG_STACK_RANGE(dg_ib, mode, 0, DG_IB_CAM + DG_IB_PROGRAMS),
    DG_STACK_RANGE(dg_ib, shift_iw, 0, IB_SHIFT_IW_MAX),
    DG_STACK_RANGE(dg_ib, program_number, 0, DG_IB_PROGRAMS),
};

/* A profile is the model's; only a K3 has an EEPROM and a gear factor. */
static bool fits(const void *own, const void *settings, const void *device)
{
    const struct dg_ib_model *mine = own;
    struct dg_ib_model model;
    struct dg_ib self;

    memcpy(&model, settings, sizeof model);
    memcpy(&self, device, sizeof self);
    if (model.profile != mine->profile || model.id_code != mine->id_code ||
        dg_ib_model_check(&model) != DG_OK) {
        return false;
    }
    return model.profile == DG_IB_K3
               ? self.store.region_count <= dg_ib_layout_of(mine)->region_count &&
                     (!self.powered || dg_ib_fits(&model, self.steps, self.revolutions))
               : !self.mounted;
}

const struct dg_stack_check dg_ib_check = {ranges, DG_COUNT(ranges), fits};
