/* SPDX-License-Identifier: MIT */
#include "drehgeber/model.h"
#include "hiperface_private.h"

static const char *settle_model(void *model)
{
    return dg_hf_model_check(model) == DG_OK
               ? NULL
               : "periods x steps at most 16777216, with the turns 2^32; implemented 0 or memory..128";
}

const struct dg_model_text dg_hf_model_text = {
    .stack = &dg_hf_stack,
    .keys = &dg_hf_keys,
    .own_size = sizeof(struct dg_hf_model),
    .size = sizeof(struct dg_hf_model),
    .settle = settle_model,
};
