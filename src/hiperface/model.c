/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: which commands one has, and what else is in a type label.
 */
#include <string.h>

#include "drehgeber/figure.h"
#include "drehgeber/model.h"
#include "drehgeber/stamp.h"
#include "hiperface_private.h"

/* All commands there are, as "42h,". */
#define COMMANDS_MAX 96u

struct text_model {
    struct dg_hf_model model;
    char commands[COMMANDS_MAX + 1u]; /* "": those of the base */
};

#define AT(field) offsetof(struct text_model, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name                  unit        offset                             type         places factor min max           words  help */
    {"commands",             "",         AT(commands),                       DG_KEY_TEXT, 0, 1, 0,  COMMANDS_MAX, NULL, "commands that it has, such as 42h,43h,50h; all others are unknown to it; default: as the base"},
    {"temperature_channel",  "",         AT(model.temperature_channel),      DG_KEY_U8,   0, 1, 0,           255, NULL, "channel of 44h, also told in the type label (factory)"},
    {"led_channel",          "",         AT(model.led_channel),              DG_KEY_U8,   0, 1, 0,           255, NULL, "channel of 44h, also told in the type label (factory)"},
    {"vector_channel",       "",         AT(model.vector_channel),           DG_KEY_U8,   0, 1, 0,           255, NULL, "channel of 44h, also told in the type label (factory)"},
    {"vector_min",           "permille", AT(model.vector_min),               DG_KEY_U16,  0, 1, 0,         65535, NULL, "limit in the type label (factory)"},
    {"vector_max",           "permille", AT(model.vector_max),               DG_KEY_U16,  0, 1, 0,         65535, NULL, "limit in the type label (factory)"},
    {"acceleration_max",     "krad/s2",  AT(model.acceleration_max_krad_s2), DG_KEY_U16,  0, 1, 0,         65535, NULL, "limit in the type label (factory)"},
};
/* clang-format on */
static const struct dg_keys more = {rows, DG_COUNT(rows)};

static void copy(void *to, const void *from)
{
    struct text_model *self = to;
    const struct dg_hf_model *base = from;

    *self = (struct text_model){.model = *base};
}

/* The first item of a list. @return characters up to the next one's first; 0: it is no command */
static size_t take_command(const char *list, uint32_t *lacks)
{
    char code[8] = "";
    struct dg_text item = dg_text_in(code, sizeof code);
    uint64_t number = 0;
    size_t n = 0;

    while (list[n] != '\0' && list[n] != ',') {
        dg_text_add_n(&item, &list[n], list[n] == ' ' ? 0 : 1u);
        n++;
    }
    if (dg_unsigned_parse(code, &number) && number <= UINT8_MAX) {
        const uint8_t row = dg_hf_command_find((uint8_t)number);
        if (row < dg_hf_command_count) {
            *lacks &= ~(UINT32_C(1) << row);
            return list[n] == ',' ? n + 1u : n;
        }
    }
    return 0;
}

/* @return false: one is none */
static bool take_commands(struct text_model *self)
{
    const char *list = self->commands;

    if (list[0] == '\0') {
        return true;
    }
    self->model.lacks = (UINT32_C(1) << dg_hf_command_count) - 1u;
    while (list[0] != '\0') {
        const size_t n = take_command(list, &self->model.lacks);
        if (n == 0) {
            return false;
        }
        list += n;
    }
    return true;
}

static const char *settle_model(void *model)
{
    if (!take_commands(model)) {
        return "commands of 42h 43h 44h 46h 47h 49h to 50h 52h 53h 55h 56h 57h 6Ah, as 42h,43h";
    }
    return dg_hf_model_check(model) == DG_OK
               ? NULL
               : "periods x steps at most 16777216, with the turns 2^32; implemented 0 or memory..128";
}

/* ---------------------------------------------------------------- EEPROM */

/* What the factory burns in, but for what is each unit's own. */
static const char *const stored_by[] = {
    "periods",
    "steps",
    "turns",
    "memory",
    "implemented",
    "type",
    "option",
    "designation",
    "temperature_min",
    "temperature_max",
    "led_min_ma",
    "led_max_ma",
    "speed_max_rpm",
    "temperature_channel",
    "led_channel",
    "vector_channel",
    "vector_min",
    "vector_max",
    "acceleration_max",
    NULL,
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
    .more = &more,
    .size = sizeof(struct text_model),
    .copy = copy,
    .settle = settle_model,
    .memory = &memory,
};
