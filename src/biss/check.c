/* SPDX-License-Identifier: MIT */
/*
 * States that somebody has made: what a device goes by, and whether it fits together.
 */
#include <string.h>

#include "biss_private.h"

#define WORD_BITS 64u
#define ID_MAX 7u

static const struct dg_stack_range ranges[] = {
    DG_STACK_RANGE(dg_biss, store.region_count, 0, DG_STORE_REGIONS_MAX),
    DG_STACK_BOOL(dg_biss, store.unapplied),
    DG_STACK_RANGE(dg_biss, line.state, 0, DG_BISS_RETURN),
    DG_STACK_RANGE(dg_biss, line.length, 0, WORD_BITS - 1u),
    DG_STACK_BOOL(dg_biss, line.ma),
    DG_STACK_BOOL(dg_biss, line.slo),
    DG_STACK_BOOL(dg_biss, line.is_last),
    DG_STACK_BOOL(dg_biss, line.hinted),
    DG_STACK_RANGE(dg_biss, control.state, 0, DG_BISS_CONTROL_STATE_COUNT - 1u),
    DG_STACK_RANGE(dg_biss, control.address, 0, BISS_ADDRESS_END),
    DG_STACK_BOOL(dg_biss, control.r),
    DG_STACK_BOOL(dg_biss, control.w),
    DG_STACK_BOOL(dg_biss, control.addressed),
    DG_STACK_BOOL(dg_biss, control.mine),
    DG_STACK_BOOL(dg_biss, control.refused),
    DG_STACK_BOOL(dg_biss, control.cds),
    DG_STACK_BOOL(dg_biss, started),
    DG_STACK_BOOL(dg_biss, mounted),
    DG_STACK_BOOL(dg_biss, configured),
    DG_STACK_BOOL(dg_biss, simulated),
    DG_STACK_BOOL(dg_biss, channel_off),
    DG_STACK_BOOL(dg_biss, communication_off),
};

/* No key sets it, so the rows of keys do not look at it: it is the model's. */
static bool knows_registers_alike(const struct dg_biss_model *mine, const void *settings)
{
    const uint8_t *bytes = settings;

    return memcmp(bytes + offsetof(struct dg_biss_model, unidirectional), &mine->unidirectional,
                  sizeof mine->unidirectional) == 0 &&
           memcmp(bytes + offsetof(struct dg_biss_model, no_eds), &mine->no_eds,
                  sizeof mine->no_eds) == 0;
}

static bool fits(const void *own, const void *settings, const void *device)
{
    const struct dg_biss_model *mine = own;
    struct dg_biss_model model;
    struct dg_biss self;

    memcpy(&model, settings, sizeof model);
    memcpy(&self, device, sizeof self);
    model.form = mine->form; /* which form frames have is not in the state */
    return knows_registers_alike(mine, settings) && dg_biss_model_ok(&model) &&
           self.store.region_count <= dg_biss_layout_of(mine)->region_count &&
           (self.control.id <= ID_MAX || self.control.id == DG_BISS_NO_ID);
}

const struct dg_stack_check dg_biss_check = {ranges, DG_COUNT(ranges), fits};
