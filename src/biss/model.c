/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: behind the figures of all BiSS encoders stand those of frames that are
 * laid out otherwise.
 */
#include <string.h>

#include "biss_private.h"
#include "drehgeber/model.h"
#include "drehgeber/stamp.h"

/* Degree 1 to 16. */
#define CRC_POLY_MIN 3u
#define CRC_POLY_MAX 0x1FFFFu

struct text_model {
    struct dg_biss_model model;
    struct dg_biss_form form;
};

/* Without a life counter, and with one. */
static const char usual_layouts[2][6] = {"PEWC", "PEWLC"};
static const char *const levels[2] = {"low", "high"};
static const char *const ways[2] = {"inverted", "plain"};

#define AT(field) offsetof(struct text_model, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name             unit offset                    type         places factor min           max           words   help */
    {"frame",           "", AT(form.layout),           DG_KEY_TEXT, 0, 1, 0,            DG_FORM_MAX,  NULL,   "parts of the frame as they are sent: P position, E error, W warning, L life counter, C CRC, 0 and 1 as they are"},
    {"error",           "", AT(form.error_high),       DG_KEY_FLAG, 0, 1, 0,            1,            levels, "level of E that is an error"},
    {"warning",         "", AT(form.warning_high),     DG_KEY_FLAG, 0, 1, 0,            1,            levels, "level of W that is a warning"},
    {"crc_poly",        "", AT(form.crc_poly),         DG_KEY_U32,  0, 1, CRC_POLY_MIN, CRC_POLY_MAX, NULL,   "polynomial of the CRC with its first bit: 25h, 43h, 190D9h"},
    {"crc_start",       "", AT(form.crc_start),        DG_KEY_U16,  0, 1, 0,            UINT16_MAX,   NULL,   "what the CRC begins with"},
    {"crc",             "", AT(form.crc_plain),        DG_KEY_FLAG, 0, 1, 0,            1,            ways,   "how the CRC is sent"},
};
/* clang-format on */
static const struct dg_keys more = {rows, DG_COUNT(rows)};

/* Registers are a whole: with them are their banks, the EDS, IDs and commands. */
static const char *const heirlooms[] = {"registers", NULL};

static void drop(void *model, size_t index)
{
    struct dg_biss_model *self = model;

    (void)index;
    self->unidirectional = true;
}

static void copy(void *to, const void *from)
{
    struct text_model *self = to;
    const struct dg_biss_model *base = from;

    *self = (struct text_model){.model = *base};
    self->model.unidirectional = false; /* until it is dropped */
    self->form = base->form == NULL ? dg_biss_any_form : *base->form;
}

/* Whether its frames are those of a model without a form. */
static bool is_usual(const struct dg_biss_form *form)
{
    return form->layout[0] == '\0' && !form->error_high && !form->warning_high &&
           form->crc_poly == dg_biss_any_form.crc_poly && form->crc_start == 0 && !form->crc_plain;
}

static const char *settle_model(void *model)
{
    struct text_model *self = model;
    const bool usual = is_usual(&self->form);
    const char *right = NULL;

    self->model.form = usual ? NULL : &self->form;
    if (!usual && self->form.layout[0] == '\0') {
        memcpy(self->form.layout, usual_layouts[self->model.life_counter], sizeof usual_layouts[0]);
    }
    right = usual ? NULL : dg_biss_form_settle(&self->model, &self->form);
    if (right == NULL &&
        self->model.multiturn_bits + self->model.singleturn_bits > BISS_USUAL_BITS_MAX && usual) {
        right = "mt and st, together at most 49";
    }
    if (right == NULL && !dg_biss_model_ok(&self->model)) {
        right = "busy_us and busy_jitter_us, together at most 40";
    }
    return right;
}

/* ---------------------------------------------------------------- EEPROM */

/* Offsets are stored in bits of the position. Whatever its width is, they are as they were: that of
 * a turn is left-aligned. */
static const char *const stored_by[] = {"mt", "st", NULL};

/* clang-format off */
static const struct dg_model_kept kept[] = {
    {DG_BISS_REGION_CONFIG, DG_BISS_REGION_CONFIG,    "offsets and masks", NULL},
    {DG_BISS_REGION_USER,   DG_BISS_REGION_COUNT - 1, "user banks",        NULL},
};
/* clang-format on */

DG_MODEL_STAMP_DEFAULTS(defaults, dg_biss_model);

static const struct dg_model_memory memory = {
    .layout_at = offsetof(struct dg_biss_model, layout),
    .figures = stored_by,
    .kept = kept,
    .kept_count = DG_COUNT(kept),
    .defaults = defaults,
};

const struct dg_model_text dg_biss_model_text = {
    .stack = &dg_biss_stack,
    .keys = &dg_biss_keys,
    .own_size = sizeof(struct dg_biss_model),
    .more = &more,
    .size = sizeof(struct text_model),
    .heirlooms = heirlooms,
    .drop = drop,
    .copy = copy,
    .settle = settle_model,
    .memory = &memory,
};
