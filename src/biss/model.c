/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: behind the figures of all BiSS encoders stand those of frames that are
 * laid out otherwise.
 */
#include <string.h>

#include "biss_private.h"
#include "drehgeber/bits.h"
#include "drehgeber/model.h"
#include "drehgeber/stamp.h"
#include "drehgeber/text.h"

/* Degree 1 to 16. */
#define CRC_POLY_MIN 3u
#define CRC_POLY_MAX 0x1FFFFu

/* 78h..7Dh; the manufacturer's follow. */
#define DEVICE_ID_SIZE 6u

struct text_model {
    struct dg_biss_model model;
    struct dg_biss_form form;
    uint16_t manufacturer;
    char device_id[2 * DEVICE_ID_SIZE + 1u]; /* hexadecimal; "": as the base */
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
    {"device_id",       "", AT(device_id),             DG_KEY_TEXT, 0, 1, 12,           12,           NULL,   "registers 78h to 7Dh, e.g. 0400C0000000; bits of turns, position and timeout in it are as they are"},
    {"manufacturer",    "", AT(manufacturer),          DG_KEY_U16,  0, 1, 0,            UINT16_MAX,   NULL,   "registers 7Eh and 7Fh, e.g. 4B55h"},
    {"profile_id",      "", AT(model.profile_id),      DG_KEY_U8,   0, 1, 0,            UINT8_MAX,    NULL,   "register 42h, and BP_ID in the EDS, e.g. 62h"},
};
/* clang-format on */
static const struct dg_keys more = {rows, DG_COUNT(rows)};

/* With registers are their banks, IDs and commands. What an EDS says is about the base's frame. */
static const char *const heirlooms[] = {"registers", "eds", NULL};

static void drop(void *model, size_t index)
{
    struct dg_biss_model *self = model;

    if (index == 0) {
        self->unidirectional = true;
    } else {
        self->no_eds = true;
    }
}

static void copy(void *to, const void *from)
{
    struct text_model *self = to;
    const struct dg_biss_model *base = from;

    *self = (struct text_model){.model = *base};
    self->model.unidirectional = false; /* until it is dropped; likewise the EDS */
    self->model.no_eds = false;
    self->manufacturer = dg_load_be16(&base->device_id[DEVICE_ID_SIZE]);
    self->form = base->form == NULL ? dg_biss_any_form : *base->form;
}

/* Whether its frames are those of a model without a form. */
static bool is_usual_form(const struct dg_biss_form *form)
{
    return form->layout[0] == '\0' && !form->error_high && !form->warning_high &&
           form->crc_poly == dg_biss_any_form.crc_poly && form->crc_start == 0 && !form->crc_plain;
}

/* @return -1: it is none */
static int hex_digit(char c)
{
    const char digit = dg_text_upper(c);

    if (digit >= '0' && digit <= '9') {
        return digit - '0';
    }
    return digit >= 'A' && digit <= 'F' ? digit - 'A' + 10 : -1;
}

/* @return false: it is no number */
static bool take_device_id(struct text_model *self)
{
    for (size_t i = 0; self->device_id[0] != '\0' && i < DEVICE_ID_SIZE; i++) {
        const int high = hex_digit(self->device_id[2u * i]);
        const int low = hex_digit(self->device_id[2u * i + 1u]);
        if (high < 0 || low < 0) {
            return false;
        }
        self->model.device_id[i] = (uint8_t)(16 * high + low);
    }
    dg_store_be16(&self->model.device_id[DEVICE_ID_SIZE], self->manufacturer);
    return true;
}

static const char *settle_model(void *model)
{
    struct text_model *self = model;
    const bool usual = is_usual_form(&self->form);
    const char *right = NULL;

    if (!take_device_id(self)) {
        return "device_id of 12 hexadecimal digits";
    }
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
