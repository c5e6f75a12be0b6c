/* SPDX-License-Identifier: MIT */
/*
 * States that somebody has made: what a device goes by, and whether it fits together.
 */
#include <string.h>

#include "ssi_private.h"

static const struct dg_stack_range ranges[] = {
    DG_STACK_RANGE(dg_ssi, state, 0, DG_SSI_SHIFT),
    DG_STACK_BOOL(dg_ssi, clock),
    DG_STACK_BOOL(dg_ssi, data),
};

/* No word was stored, or one of this model; which form it has is not in the state. */
static bool fits(const void *own, const void *settings, const void *device)
{
    const struct dg_ssi_model *mine = own;
    struct dg_ssi_model model;
    struct dg_ssi self;

    memcpy(&model, settings, sizeof model);
    memcpy(&self, device, sizeof self);
    model.form = mine->form;
    return dg_ssi_model_ok(&model) && self.left <= dg_ssi_word_bits(&model) &&
           (self.bits == 0 || self.bits == dg_ssi_word_bits(&model));
}

const struct dg_stack_check dg_ssi_check = {ranges, DG_COUNT(ranges), fits};
