/* SPDX-License-Identifier: MIT */
#include "control_private.h"

const struct dg_encoder_kind *dg_encoder_kind_of(const struct dg_stack *stack)
{
    static const struct dg_encoder_kind *const kinds[] = {
        &dg_kind_hiperface,
        &dg_kind_biss,
        &dg_kind_canopen,
        &dg_kind_interbus,
    };

    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (kinds[i]->stack == stack) {
            return kinds[i];
        }
    }
    return NULL;
}
