/* SPDX-License-Identifier: MIT */
/*
 * What can be set of an S36 RS485: its address and its factory figures.
 */
#include "drehgeber/hiperface.h"

#define AT(field) offsetof(struct dg_hf_settings, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name             unit      offset                           type           places factor                  min                        max  words help */
    {"address",         "",       AT(address),                     DG_KEY_U32,    0, 1,       DG_HF_ADDRESS_DEFAULT,        DG_HF_ADDRESS_LAST, NULL, "RS485 address of a new EEPROM"},
    {"serial",          "",       AT(model.serial),                DG_KEY_DIGITS, 0, 1,                           1,                         9, NULL, "serial number"},
    {"reaction_us",     "us",     AT(model.reaction),              DG_KEY_NS,     0, 1000,                        0,                    250000, NULL, "time from the timeout that ends a request to the reply, limited to the command's maximum"},
    {"init_ms",         "ms",     AT(model.init),                  DG_KEY_NS,     0, 1000000,                     0, DG_HF_INIT_MAX / DG_MS(1), NULL, "time for initialisation after power-on and reset"},
    {"periods",         "",       AT(model.periods_per_turn),      DG_KEY_U16,    0, 1,                           1,                     65535, NULL, "sine periods per turn (factory)"},
    {"steps",           "",       AT(model.steps_per_period),      DG_KEY_U32,    0, 1,                           1,  DG_HF_STEPS_PER_TURN_MAX, NULL, "steps of 42h per period; periods x steps is at most 16777216 (factory)"},
    {"turns",           "",       AT(model.turns),                 DG_KEY_U32,    0, 1,                           1,                UINT32_MAX, NULL, "turns; 1: singleturn (factory)"},
    {"memory",          "blocks", AT(model.memory_blocks),         DG_KEY_U8,     0, 1,                           1,                       112, NULL, "user memory in blocks of 16 bytes (factory)"},
    {"implemented",     "blocks", AT(model.implemented_blocks),    DG_KEY_U8,     0, 1,                           0,     DG_HF_IMPLEMENTED_MAX, NULL, "memory size that 52h reports, memory..128; 0: the same as memory (factory)"},
    {"type",            "",       AT(model.type_code),             DG_KEY_U8,     0, 1,                           0,                       255, NULL, "type code, e.g. 27h (factory)"},
    {"option",          "",       AT(model.option_code),           DG_KEY_U8,     0, 1,                           0,                       255, NULL, "option code (factory)"},
    {"version",         "",       AT(model.version),               DG_KEY_TEXT,   0, 1,                           0,                        19, NULL, "firmware version (factory)"},
    {"date",            "",       AT(model.date),                  DG_KEY_TEXT,   0, 1,                           8,                         8, NULL, "date of the firmware (factory)"},
    {"designation",     "",       AT(model.designation),           DG_KEY_TEXT,   0, 1,                           0,                        18, NULL, "designation in the type label (factory)"},
    {"temperature_min", "degC",   AT(model.temperature_min_degc),  DG_KEY_I16,    0, 1,                        -273,                      1000, NULL, "limit in the type label (factory)"},
    {"temperature_max", "degC",   AT(model.temperature_max_degc),  DG_KEY_I16,    0, 1,                        -273,                      1000, NULL, "limit in the type label (factory)"},
    {"led_min_ma",      "mA",     AT(model.led_min_ma),            DG_KEY_U16,    0, 1,                           0,                     65535, NULL, "limit in the type label (factory)"},
    {"led_max_ma",      "mA",     AT(model.led_max_ma),            DG_KEY_U16,    0, 1,                           0,                     65535, NULL, "limit in the type label (factory)"},
    {"speed_max_rpm",   "rpm",    AT(model.speed_max_rpm),         DG_KEY_U16,    0, 1,                           1,                     65535, NULL, "highest speed at which the encoder has a position (factory)"},
};
/* clang-format on */

const struct dg_keys dg_hf_keys = {rows, DG_COUNT(rows)};
