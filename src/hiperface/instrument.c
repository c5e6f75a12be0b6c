/* SPDX-License-Identifier: MIT */
/*
 * The S36 RS485 as an instrument. The value of a defect is beyond the limits as delivered; where a
 * limit is configuration (the type label) it may have to be chosen by WORLd instead. 'no.' counts
 * the choices of this folder's page.
 */
#include "drehgeber/hiperface.h"
#include "drehgeber/instruments.h"

static const char *mode(const void *self, dg_ns now)
{
    const struct dg_hf *device = self;

    (void)now;
    if (device->line == DG_HF_OFF) {
        return "off";
    }
    if (device->line == DG_HF_DEAF) {
        return "initialising";
    }
    return device->window_end != DG_NEVER ? "window" : "on";
}

static void put_status_errors(const struct dg_hf *device, struct dg_scpi *to)
{
    bool first = true;

    dg_state_begin(to, "errors");
    for (uint8_t i = device->stack_count; i > 0; i--) {
        dg_state_item(to, &first, device->stack[i - 1u], 2);
    }
    dg_state_end(to, first);
}

/* The process channel at the moment of `position`; without power it has no level. */
static void put_sincos(const struct dg_hf *device, dg_ns now, bool on, struct dg_scpi *to)
{
    struct dg_hf_sincos lines = {0};

    dg_hf_sincos(device, now, &lines);
    const struct {
        const char *key;
        int32_t uv;
    } rows[] = {
        {"sin_plus_uv", lines.sin_plus_uv},
        {"sin_minus_uv", lines.sin_minus_uv},
        {"cos_plus_uv", lines.cos_plus_uv},
        {"cos_minus_uv", lines.cos_minus_uv},
    };
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        dg_state_begin(to, rows[i].key);
        if (on) {
            dg_scpi_append_number(to, rows[i].uv, 0);
        } else {
            dg_scpi_append(to, "-");
        }
    }
}

static void state(const void *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_hf *device = self;
    const struct dg_hf_counters *counters = &device->counters;
    const bool on = device->line != DG_HF_OFF;
    const struct dg_hf_uart uart = dg_hf_uart(device);
    const char parity[2] = {uart.parity};

    dg_state_word(to, "leds", "-");
    put_status_errors(device, to);
    dg_state_number(to, "frames", counters->frames);
    dg_state_number(to, "replies", counters->replies);
    dg_state_number(to, "error_replies", counters->errors);
    dg_state_number(to, "others", counters->others);
    dg_state_number(to, "damaged", counters->damaged);
    dg_state_number(to, "interrupted", counters->interrupted);
    dg_state_number(to, "deaf", counters->deaf);
    dg_state_hex(to, "address", device->address, 2);
    dg_state_number(to, "baud", uart.baud);
    dg_state_word(to, "parity", parity);
    dg_state_hex(to, "locks", device->locks, 2);
    put_sincos(device, now, on, to);
}

/* clang-format off */
static const struct dg_fault_row faults[] = {
    {"led_current_high",    DG_FAULT_SENSES(led_current_ua),                       40000, DG_CAUSE_LED_WORN,  "1Dh on the error stack; 42h, 43h, 6Ah answer 1Dh; 44h channel 49h reads 40 mA", "5.1.3"},
    {"led_current_low",     DG_FAULT_SENSES(led_current_ua),                           0, "the LED of the scanner has no current", "44h channel 49h reads 0 mA, below the type label's minimum; no code", "5.1.2.3; no. 26"},
    {"temperature_high",    DG_FAULT_SENSES(temperature_mdegc),                   125000, DG_CAUSE_HOT,       "1Eh on the error stack; 44h channel 48h reads 125 degC", "5.1.3"},
    {"temperature_low",     DG_FAULT_SENSES(temperature_mdegc),                   -45000, DG_CAUSE_COLD,      "1Eh on the error stack; 44h channel 48h reads -45 degC", "5.1.3"},
    {"sin_amplitude_low",   DG_FAULT_SENSES(sin_amplitude_permille),                 500, DG_CAUSE_DIRT,      "the sine signal is half as high; 44h channel 4Ah reads 500 where it peaks; no code", "4.1.3; no. 26"},
    {"sin_amplitude_high",  DG_FAULT_SENSES(sin_amplitude_permille),                1500, DG_CAUSE_GAIN,      "the sine signal is 1.5 times as high; 44h channel 4Ah reads 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"cos_amplitude_low",   DG_FAULT_SENSES(cos_amplitude_permille),                 500, DG_CAUSE_DIRT,      "the cosine signal is half as high; 44h channel 4Ah reads 500 where it peaks; no code", "4.1.3; no. 26"},
    {"cos_amplitude_high",  DG_FAULT_SENSES(cos_amplitude_permille),                1500, DG_CAUSE_GAIN,      "the cosine signal is 1.5 times as high; 44h channel 4Ah reads 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"sin_offset",          DG_FAULT_SENSES(sin_offset_permille),                    500, DG_CAUSE_STRAY,     "the sine signal is shifted by half its peak; 44h channel 4Ah reads 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"cos_offset",          DG_FAULT_SENSES(cos_offset_permille),                    500, DG_CAUSE_STRAY,     "the cosine signal is shifted by half its peak; 44h channel 4Ah reads 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"singleturn_lost",     DG_FAULT_SENSES(singleturn_ok),                            0, DG_CAUSE_SCRATCH,   "42h, 43h, 6Ah answer 20h", "5.1.3"},
    {"multiturn_amplitude", DG_FAULT_SENSES(multiturn_amplitude_ok),                   0, DG_CAUSE_MT_WEAK,   "multiturn: 42h, 43h, 6Ah answer 21h", "5.1.3"},
    {"multiturn_sync",      DG_FAULT_SENSES(multiturn_sync_ok),                        0, DG_CAUSE_MT_SYNC,   "multiturn: 42h, 43h, 6Ah answer 22h", "5.1.3"},
    {"multiturn_vector",    DG_FAULT_SENSES(multiturn_vector_ok),                      0, DG_CAUSE_MT_VECTOR, "multiturn: 42h, 43h, 6Ah answer 23h", "5.1.3"},
    {"eeprom_silent",       DG_FAULT_SENSES(eeprom_acknowledges),                      0, DG_CAUSE_SILENT,    "commands on the EEPROM answer 05h; if it is silent at a start, 05h on the error stack, 42h, 43h, 6Ah answer 02h until the next start", "5.1.3.5; no. 2"},
    {"wire_drop",           DG_FAULT_ON_WIRE(DROP),                                    0, "the line driver is broken", "the reply does not come", "5.1.1"},
    {"wire_deaf",           DG_FAULT_ON_WIRE(DEAF),                                    0, "the line receiver is broken", "the encoder does not receive the request: no reply", "5.1.1"},
    {"wire_delay",          DG_FAULT_ON_WIRE(DELAY),                 (int64_t)DG_MS(300), "the firmware is busy", "the reply comes 300 ms late, after every command's longest reaction time", "5.1.2"},
    {"wire_damage",         DG_FAULT_ON_WIRE(DAMAGE),                                  0, "a disturbance on the line", "one bit of the reply is flipped: its check sum is wrong", "5.1.1"},
    {"wire_duplicate",      DG_FAULT_ON_WIRE(DUPLICATE),                               0, "a repeater with an echo", "the reply comes twice", "5.1.1"},
};

static const struct dg_damage_row damage[] = {
    {NULL, "from the next start on: the region's code, then 06h on the error stack; commands bound to it answer 02h, 03h, 05h or 06h", "5.1.3"},
};
/* clang-format on */

const struct dg_instrument dg_hf_instrument = {
    .stack = &dg_hf_stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .damage = damage,
    .mode = mode,
    .state = state,
};
