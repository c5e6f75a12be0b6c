/* SPDX-License-Identifier: MIT */
#include "control_private.h"

const struct dg_encoder_kind *dg_encoder_kind_of(enum dg_device_stack stack)
{
    static const struct dg_encoder_kind *const kinds[] = {
        [DG_STACK_HIPERFACE] = &dg_kind_hiperface,
        [DG_STACK_BISS] = &dg_kind_biss,
        [DG_STACK_CANOPEN] = &dg_kind_canopen,
        [DG_STACK_INTERBUS] = &dg_kind_interbus,
    };

    return kinds[stack];
}
