/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts.
 */
#include "drehgeber/model.h"
#include "drehgeber/stamp.h"
#include "hiperface_private.h"

static const char *settle_model(void *model)
{
    return dg_hf_model_check(model) == DG_OK
               ? NULL
               : "periods x steps at most 16777216, with the turns 2^32; implemented 0 or memory..128";
}

/* ---------------------------------------------------------------- EEPROM */

/* What the factory burns in, but for what is each unit's own. */
static const char *const stored_by[] = {
    "periods",         "steps",       "turns",
    "memory",          "implemented", "type",
    "option",          "designation", "temperature_min",
    "temperature_max", "led_min_ma",  "led_max_ma",
    "speed_max_rpm",   NULL,
};
static const char *const of_position[] = {"periods", "steps", "turns", NULL};
static const char *const of_fields[] = {"memory", NULL};

/* clang-format off */
static const struct dg_model_kept kept[] = {
    {DG_HF_REGION_OFFSET,     DG_HF_REGION_OFFSET,  "position offset",      of_position},
    {DG_HF_REGION_UART,       DG_HF_REGION_UART,    "setting of the UART",  NULL},
    {DG_HF_REGION_CODES,      DG_HF_REGION_CODES,   "access codes",         NULL},
    {DG_HF_REGION_COUNTER,    DG_HF_REGION_COUNTER, "counter",              NULL},
    {DG_HF_REGION_FIELDS,     DG_HF_REGION_FIELDS,  "data fields",          of_fields},
    {DG_HF_REGION_FIELD_SUMS, DG_HF_REGION_USER,    NULL,                   of_fields},
};
/* clang-format on */

DG_MODEL_STAMP_DEFAULTS(defaults, dg_hf_model);

static const struct dg_model_memory memory = {
    .layout_at = offsetof(struct dg_hf_model, layout),
    .figures = stored_by,
    .kept = kept,
    .kept_count = DG_COUNT(kept),
    .defaults = defaults,
};

const struct dg_model_text dg_hf_model_text = {
    .stack = &dg_hf_stack,
    .keys = &dg_hf_keys,
    .own_size = sizeof(struct dg_hf_model),
    .size = sizeof(struct dg_hf_model),
    .settle = settle_model,
    .memory = &memory,
};
