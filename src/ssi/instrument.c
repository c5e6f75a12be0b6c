/* SPDX-License-Identifier: MIT */
/*
 * SSI as an instrument. SSI: words through a wire that the host clocks.
 */
#include "drehgeber/control.h"
#include "drehgeber/instruments.h"
#include "drehgeber/ssi.h"

static const char *mode(const void *self, dg_ns now)
{
    static const char *const modes[] = {
        [DG_SSI_OFF] = "off",
        [DG_SSI_START] = "initialising",
        [DG_SSI_IDLE] = "idle",
        [DG_SSI_SHIFT] = "transmitting",
    };
    _Static_assert(DG_COUNT(modes) == DG_SSI_STATE_COUNT, "a word for each");
    const struct dg_ssi *device = self;
    const bool over = device->state != DG_SSI_OFF && now >= device->deadline;

    return modes[over ? DG_SSI_IDLE : device->state];
}

static void state(const void *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_ssi *device = self;
    const struct dg_ssi_counters *counters = &device->counters;

    (void)now;
    dg_state_word(to, "leds", "-");
    dg_state_error_bits(to, device->state == DG_SSI_OFF ? 0 : dg_ssi_errors(device));
    dg_state_number(to, "frames", counters->frames);
    dg_state_number(to, "repeats", counters->repeats);
    dg_state_number(to, "aborted", counters->aborted);
    dg_state_number(to, "fast", counters->fast);
    dg_state_hex(to, "word", device->word, (dg_ssi_word_bits(device->setup.model) + 3u) / 4u);
}

static const struct dg_ssi_port_ops *ssi_port_of(struct dg_scpi *session)
{
    return dg_control_port(session, &dg_ssi_stack, "it is no SSI encoder", "no simulated SSI wire");
}

static void frame(struct dg_scpi *session)
{
    const struct dg_encoder *encoder = dg_control_selected(session);
    const struct dg_ssi_port_ops *port = ssi_port_of(session);
    char detail[DG_SCPI_DETAIL_MAX + 1u] = "";
    uint64_t bits = 0;

    if (port == NULL) {
        return;
    }
    const int code = port->frame(encoder->port_ctx, &bits, detail);
    if (code != DG_SCPI_NO_ERROR) {
        dg_scpi_raise(session, code, detail);
        return;
    }
    const struct dg_ssi *device = encoder->device;
    struct dg_ssi_frame word;
    const int parity = dg_ssi_frame_decode(device->setup.model, bits, &word);
    dg_scpi_put_unsigned(session, word.position);
    dg_scpi_put_unsigned(session, word.error ? 1 : 0);
    dg_scpi_put_unsigned(session, parity == DG_OK ? 1 : 0);
}

static void line_frame(const void *self, struct dg_line_frame *to)
{
    const struct dg_ssi *device = self;

    to->bits = dg_ssi_word_bits(device->setup.model);
}

static bool clock_of(const void *self)
{
    const struct dg_ssi *device = self;

    return device->clock;
}

/* clang-format off */
#define CAUSE_SUPPLY "the supply's voltage drops on the cable"
static const struct dg_fault_row faults[] = {
    {"led_current_high",    DG_FAULT_SENSES(led_current_ua),            40000, DG_CAUSE_LED_WORN,  "the error bit is set", "S13"},
    {"temperature_high",    DG_FAULT_SENSES(temperature_mdegc),        125000, DG_CAUSE_HOT,       "the error bit is set", "S13"},
    {"temperature_low",     DG_FAULT_SENSES(temperature_mdegc),        -45000, DG_CAUSE_COLD,      "the error bit is set", "S13"},
    {"supply_low",          DG_FAULT_SENSES(supply_mv),                  4500, CAUSE_SUPPLY,       "the error bit is set", "S13"},
    {"sin_amplitude_low",   DG_FAULT_SENSES(sin_amplitude_permille),      500, DG_CAUSE_DIRT,      "the error bit is set", "S13"},
    {"sin_amplitude_high",  DG_FAULT_SENSES(sin_amplitude_permille),     1500, DG_CAUSE_GAIN,      "the error bit is set", "S13"},
    {"cos_amplitude_low",   DG_FAULT_SENSES(cos_amplitude_permille),      500, DG_CAUSE_DIRT,      "the error bit is set", "S13"},
    {"cos_amplitude_high",  DG_FAULT_SENSES(cos_amplitude_permille),     1500, DG_CAUSE_GAIN,      "the error bit is set", "S13"},
    {"sin_offset",          DG_FAULT_SENSES(sin_offset_permille),         500, DG_CAUSE_STRAY,     "the error bit is set", "S13"},
    {"cos_offset",          DG_FAULT_SENSES(cos_offset_permille),         500, DG_CAUSE_STRAY,     "the error bit is set", "S13"},
    {"singleturn_lost",     DG_FAULT_SENSES(singleturn_ok),                 0, DG_CAUSE_SCRATCH,   "the error bit is set; the position goes on", "S13; S14"},
    {"multiturn_amplitude", DG_FAULT_SENSES(multiturn_amplitude_ok),        0, DG_CAUSE_MT_WEAK,   "multiturn: the error bit is set; the position goes on", "S13; S16"},
    {"multiturn_sync",      DG_FAULT_SENSES(multiturn_sync_ok),             0, DG_CAUSE_MT_SYNC,   "multiturn: the error bit is set; the position goes on", "S13; S16"},
    {"multiturn_vector",    DG_FAULT_SENSES(multiturn_vector_ok),           0, DG_CAUSE_MT_VECTOR, "multiturn: the error bit is set; the position goes on", "S13; S16"},
    {"watchdog_fired",      DG_FAULT_SENSES(watchdog_fired),                1, DG_CAUSE_WATCHDOG,  "the error bit is set", "S13"},
    {"wire_drop",           DG_FAULT_ON_WIRE(DROP),                         0, "the line driver is broken now and then", "data stays low for the word: no supply, to the master", "S7"},
    {"wire_delay",          DG_FAULT_ON_WIRE(DELAY),        (int64_t)DG_US(1), "the cable is too long for the clock", "each bit is read a clock late: a 1 in front, no 0 behind", "S6"},
    {"wire_damage",         DG_FAULT_ON_WIRE(DAMAGE),                       0, "a disturbance on the line", "one bit of the word is flipped: another position, or the parity is wrong", "S12"},
    {"wire_break",          DG_FAULT_ON_WIRE(BREAK),                        0, "a wire of the data line is broken", "data reads low: no supply, to the master", "S7"},
};

static const struct dg_scpi_command commands[] = {
    {"SSI:FRAMe", NULL, frame, 0, "", "clock a word of a simulated wire: position, error, parity right"},
};
/* clang-format on */

const struct dg_instrument dg_ssi_instrument = {
    .stack = &dg_ssi_stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .mode = mode,
    .state = state,
    .commands = {commands, DG_COUNT(commands)},
    .line_frame = line_frame,
    .clock = clock_of,
};
