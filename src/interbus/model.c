/* SPDX-License-Identifier: MIT */
#include "drehgeber/model.h"
#include "interbus_private.h"

static const char *settle_model(void *model)
{
    return dg_ib_model_check(model) == DG_OK
               ? NULL
               : "steps x turns at most 65536 for a K1, steps from 2 on with steps_minus_one";
}

const struct dg_model_text dg_ib_model_text = {
    .stack = &dg_ib_stack,
    .keys = &dg_ib_keys,
    .own_size = sizeof(struct dg_ib_model),
    .size = sizeof(struct dg_ib_model),
    .settle = settle_model,
};
