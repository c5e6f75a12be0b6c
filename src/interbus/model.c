/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: their profile, and the class that their ID word tells.
 */
#include "drehgeber/model.h"
#include "drehgeber/stamp.h"
#include "interbus_private.h"

/* The profile as a key can set it. */
struct text_model {
    struct dg_ib_model model;
    uint8_t profile;
};

static const char *const profiles[DG_IB_PROFILE_COUNT] = {"k1", "k2", "k3"};

#define AT(field) offsetof(struct text_model, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name       unit offset           type         places factor min max                      words     help */
    {"profile",   "",  AT(profile),       DG_KEY_WORD, 0, 1, 0,    DG_IB_PROFILE_COUNT - 1, profiles, "k1: a word of data; k2: two; k3: two, with parameters and an EEPROM"},
    {"id_code",   "",  AT(model.id_code), DG_KEY_U8,   0, 1, 0,    255,                     NULL,     "lower byte of the ID word, e.g. 33h; 0: 36h, 37h, B2h or B3h, by profile and loop"},
};
/* clang-format on */
static const struct dg_keys more = {rows, DG_COUNT(rows)};

static void copy(void *to, const void *from)
{
    struct text_model *self = to;
    const struct dg_ib_model *base = from;

    *self = (struct text_model){.model = *base, .profile = (uint8_t)base->profile};
}

static const char *settle_model(void *model)
{
    struct text_model *self = model;

    self->model.profile = (enum dg_ib_profile)self->profile;
    return dg_ib_model_check(&self->model) == DG_OK
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
    .more = &more,
    .size = sizeof(struct text_model),
    .copy = copy,
    .settle = settle_model,
    .memory = &memory,
};
