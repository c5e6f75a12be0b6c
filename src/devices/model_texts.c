/* SPDX-License-Identifier: MIT */
/*
 * What texts can say of models; each is described in its protocol's folder.
 */
#include "drehgeber/devices.h"
#include "drehgeber/hal.h"
#include "drehgeber/model.h"
#include "drehgeber/protocols.h"

#define ROW(prefix) &dg_##prefix##_model_text,
static const struct dg_model_text *const texts[] = {DG_PROTOCOLS_WITH_MODEL_TEXT(ROW)};
#undef ROW

const struct dg_model_text *dg_model_text_of(const struct dg_stack *stack)
{
    for (size_t i = 0; i < DG_COUNT(texts); i++) {
        if (texts[i]->stack == stack) {
            return texts[i];
        }
    }
    return NULL;
}
