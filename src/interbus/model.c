/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts.
 */
#include "drehgeber/model.h"
#include "drehgeber/stamp.h"
#include "interbus_private.h"

static const char *settle_model(void *model)
{
    return dg_ib_model_check(model) == DG_OK
               ? NULL
               : "steps x turns at most 65536 for a K1, steps from 2 on with steps_minus_one";
}

/* ---------------------------------------------------------------- EEPROM of a K3 */

static const char *const stored_by[] = {"steps", "turns", "steps_minus_one", NULL};

/* Positions are in steps of the discs; which way they count, and what is shown, are not. */
/* clang-format off */
static const struct dg_model_kept kept[] = {
    {DG_IB_REGION_STEPS,     DG_IB_REGION_REVOLUTIONS, "steps and revolutions", stored_by},
    {DG_IB_REGION_DIRECTION, DG_IB_REGION_DIRECTION,   "direction",             NULL},
    {DG_IB_REGION_PRESET,    DG_IB_REGION_SHIFT,       "preset and shift",      stored_by},
    {DG_IB_REGION_MODE,      DG_IB_REGION_SHIFT_IW,    "mode",                  NULL},
    {DG_IB_REGION_CAMS,      DG_IB_REGION_TIME - 1,    "cam programs",          stored_by},
    {DG_IB_REGION_TIME,      DG_IB_REGION_TIME,        "operating time",        NULL},
};
/* clang-format on */

DG_MODEL_STAMP_DEFAULTS(defaults, dg_ib_model);

static const struct dg_model_memory memory = {
    .layout_at = offsetof(struct dg_ib_model, layout),
    .figures = stored_by,
    .kept = kept,
    .kept_count = DG_COUNT(kept),
    .defaults = defaults,
};

const struct dg_model_text dg_ib_model_text = {
    .stack = &dg_ib_stack,
    .keys = &dg_ib_keys,
    .own_size = sizeof(struct dg_ib_model),
    .size = sizeof(struct dg_ib_model),
    .settle = settle_model,
    .memory = &memory,
};
