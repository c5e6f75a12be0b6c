/* SPDX-License-Identifier: MIT */
#include "hf_settings.h"
#include "trace_format.h"

#include <stddef.h>

static const char *const own_any[2] = {"own", "any"};

#define AT(field) offsetof(struct lx_hf_settings, field)

/* clang-format off */
static const struct dg_key keys[] = {
    /* name            unit       offset                             type       places factor   min         max  words     help */
    {"pace",            "",        AT(pace),                           DG_KEY_FLAG,   0, 1,            0,          1, dg_key_no_yes, "requests and replies at the speed of the line; 0: at once"},
    {"line",            "",        AT(any_line),                       DG_KEY_FLAG,   0, 1,            0,          1, own_any,  "data rate the master must use: the encoder's own, or any"},
    {"sincos_us",       "us",      AT(sincos),                         DG_KEY_NS,     0, 1000,         0,    1000000, NULL,     "sine and cosine in a VCD trace: time between samples; 0: none"},
    {"reaction_us",     "us",      AT(model.reaction),                 DG_KEY_NS,     0, 1000,         0,     250000, NULL,     "from a request's timeout to the reply; cut to the command's maximum"},
    {"init_ms",         "ms",      AT(model.init),                     DG_KEY_NS,     0, 1000000,      0,     600000, NULL,     "initialisation time after power-on and reset"},
    {"periods",         "",        AT(model.periods_per_turn),         DG_KEY_U16,    0, 1,            1,      65535, NULL,     "sine periods a turn (factory)"},
    {"steps",           "",        AT(model.steps_per_period),         DG_KEY_U32,    0, 1,            1,   16777216, NULL,     "steps of 42h in a period; periods x steps: at most 16777216 (factory)"},
    {"turns",           "",        AT(model.turns),                    DG_KEY_U32,    0, 1,            1, UINT32_MAX, NULL,     "turns; 1: singleturn (factory)"},
    {"memory",          "blocks",  AT(model.memory_blocks),            DG_KEY_U8,     0, 1,            1,        112, NULL,     "user memory in blocks of 16 bytes (factory)"},
    {"implemented",     "blocks",  AT(model.implemented_blocks),       DG_KEY_U8,     0, 1,            0,        128, NULL,     "memory size that 52h tells, memory..128; 0: as memory (factory)"},
    {"type",            "",        AT(model.type_code),                DG_KEY_U8,     0, 1,            0,        255, NULL,     "type code, e.g. 27h (factory)"},
    {"option",          "",        AT(model.option_code),              DG_KEY_U8,     0, 1,            0,        255, NULL,     "option code (factory)"},
    {"version",         "",        AT(model.version),                  DG_KEY_TEXT,   0, 1,            0,         19, NULL,     "firmware version (factory)"},
    {"date",            "",        AT(model.date),                     DG_KEY_TEXT,   0, 1,            8,          8, NULL,     "date of the firmware (factory)"},
    {"designation",     "",        AT(model.designation),              DG_KEY_TEXT,   0, 1,            0,         18, NULL,     "designation in the type label (factory)"},
    {"temperature_min", "degC",    AT(model.temperature_min_degc),     DG_KEY_I16,    0, 1,         -273,       1000, NULL,     "limit in the type label (factory)"},
    {"temperature_max", "degC",    AT(model.temperature_max_degc),     DG_KEY_I16,    0, 1,         -273,       1000, NULL,     "limit in the type label (factory)"},
    {"led_min_ma",      "mA",      AT(model.led_min_ma),               DG_KEY_U16,    0, 1,            0,      65535, NULL,     "limit in the type label (factory)"},
    {"led_max_ma",      "mA",      AT(model.led_max_ma),               DG_KEY_U16,    0, 1,            0,      65535, NULL,     "limit in the type label (factory)"},
    {"speed_max_rpm",   "rpm",     AT(model.speed_max_rpm),            DG_KEY_U16,    0, 1,            1,      65535, NULL,     "fastest speed with a position (factory)"},
};

static const struct dg_key serial =
    {"serial",         "",        AT(model.serial),                  DG_KEY_DIGITS,  0, 1,        1,          9, NULL,     "serial number"};
/* clang-format on */

static void defaults(void *settings, const struct dg_device *device)
{
    struct lx_hf_settings *self = settings;
    *self = (struct lx_hf_settings){
        .model = *dg_hf_model_of(device),
        .pace = true,
        .sincos = DG_MS(1),
    };
}

static int check_steps(const struct dg_hf_model *model, struct lx_error *error)
{
    const uint64_t steps = (uint64_t)model->periods_per_turn * model->steps_per_period;
    const uint64_t counts = steps * model->turns;
    struct lx_words right = {""};
    if (steps > DG_HF_STEPS_PER_TURN_MAX) {
        lx_words_add(&right, "at most %lu is right", (unsigned long)DG_HF_STEPS_PER_TURN_MAX);
        return lx_refuse(error, right.text, "periods x steps is %llu", (unsigned long long)steps);
    }
    /* 42h answers with 32 bits of position. */
    return counts <= (uint64_t)1 << 32
               ? 0
               : lx_refuse(error, "at most 4294967296 is right", "turns x periods x steps is %llu",
                           (unsigned long long)counts);
}

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_hf_model *model = &((const struct lx_hf_settings *)settings)->model;
    struct lx_words right = {""};
    if (model->implemented_blocks != 0 && model->implemented_blocks < model->memory_blocks) {
        lx_words_add(&right, "%u..128 is right, or 0: as memory", model->memory_blocks);
        return lx_refuse(error, right.text, "implemented is %u", model->implemented_blocks);
    }
    return check_steps(model, error);
}

static const char title[] = "RS485";
static const struct lx_trace_format *const formats[] = {&lx_trace_uart, NULL};
static const struct lx_trace_kind trace = {title, formats, true};

const struct lx_stack lx_hf_stack = {
    .core = &dg_hf_stack,
    .title = title,
    .trace = &trace,
    .wire = "pty",
    .address = {"address", "an RS485 address", DG_HF_ADDRESS_DEFAULT, DG_HF_ADDRESS_LAST,
                DG_HF_ADDRESS_DEFAULT, true},
    .keys = keys,
    .key_count = DG_COUNT(keys),
    .serial = &serial,
    .settings_size = sizeof(struct lx_hf_settings),
    .defaults = defaults,
    .check = check,
};
