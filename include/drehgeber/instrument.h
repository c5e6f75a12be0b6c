/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A protocol as an instrument: what the control plane needs to know of it beyond its struct
 * dg_stack. Each is one const object in a file of its own, src/FOLDER/instrument.c, so that an
 * image without the control plane carries nothing of it; those of this library are in
 * instruments.h.
 */
#ifndef DREHGEBER_INSTRUMENT_H
#define DREHGEBER_INSTRUMENT_H

#include "drehgeber/api.h"
#include "drehgeber/fault.h"
#include "drehgeber/scpi.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What the device says to damage of a region of its EEPROM. */
struct dg_damage_row {
    const char *region; /**< NULL: any other; the last row */
    const char *effect; /**< as dg_fault_row.effect */
    const char *chapter;
};

/** What a frame on a clocked line looks like to its faults (line_fault.h); clocks are rising edges.
 */
struct dg_line_frame {
    uint8_t lead;  /**< clocks that a frame begins with and that are never late */
    bool waits;    /**< behind them the line is low up to the start bit, which is high; otherwise
                        it is high, and the data follows at once */
    uint8_t ahead; /**< bits between the start bit and the data */
    uint8_t bits;  /**< of the data, 1 at least */
    bool open;     /**< what a line reads as that nobody drives */
    dg_ns delay;   /**< of DG_WIRE_DELAY; left alone by dg_instrument.line_frame() */
};

/** A protocol as an instrument. */
struct dg_instrument {
    const struct dg_stack *stack;
    const struct dg_fault_row *faults; /**< what can happen to its world and its wire */
    size_t fault_count;
    const struct dg_damage_row *damage; /**< up to the row for any other region */
    /** STATe?: the mode that `device` is in at `now`, a word; "off" without power. */
    const char *(*mode)(const void *device, dg_ns now);
    /**
     * STATe?: append KEY=VALUE parts (dg_state_*) behind power, mode and position. All have leds
     * (NAME:on, off or a pattern, with '/' between them; '-' without LEDs), errors (codes in hex,
     * newest first, '-' without) and frames; then counters and what is its own.
     */
    void (*state)(const void *device, dg_ns now, struct dg_scpi *to);
    struct dg_scpi_commands commands; /**< of its own; usually none */
    /** The frames of `device`. NULL: its line is not clocked. */
    void (*line_frame)(const void *device, struct dg_line_frame *to);
    /** The level of the clock as `device` has it. NULL likewise. */
    bool (*clock)(const void *device);
    /** What happens by chance in `device` goes by `seed` from now on. NULL: nothing does. */
    void (*seed)(void *device, uint32_t seed);
};

/** A quantity of the world: kind, wire, size and offset of a dg_fault_row. */
#define DG_FAULT_SENSES(member)                                                                    \
    DG_FAULT_WORLD, 0, sizeof(((struct dg_world *)0)->member), offsetof(struct dg_world, member)
/** An enum dg_wire_fault: the same. */
#define DG_FAULT_ON_WIRE(what) DG_FAULT_WIRE, DG_WIRE_##what, 0, 0

/** Causes that several instruments have. */
#define DG_CAUSE_LED_WORN "the LED of the scanner is worn out: its current is regulated up"
#define DG_CAUSE_HOT "the housing is too hot"
#define DG_CAUSE_COLD "the housing is too cold"
#define DG_CAUSE_DIRT "dirt in front of the receiver of this track"
#define DG_CAUSE_GAIN "the amplifier of this track has too much gain"
#define DG_CAUSE_STRAY "stray light on the receiver of this track"
#define DG_CAUSE_SCRATCH "the singleturn track cannot be read"
#define DG_CAUSE_MT_WEAK "the multiturn sensor's magnet is too weak"
#define DG_CAUSE_MT_SYNC "multiturn and singleturn do not agree: a gear has slipped"
#define DG_CAUSE_MT_VECTOR "the multiturn sensor's vector is out of range: a foreign magnetic field"
#define DG_CAUSE_SILENT "the EEPROM does not acknowledge on its I2C bus"
#define DG_CAUSE_WATCHDOG "the processor hung, and its watchdog has reset it"

/* ---------------------------------------------------------------- for dg_instrument.state */

/** Begin the part `key`: its value is what dg_scpi_append*() adds. A value has neither ',' nor ';';
 * lists have '/', nothing is '-'. */
DG_API void dg_state_begin(struct dg_scpi *to, const char *key);
/** A whole part whose value is a word. */
DG_API void dg_state_word(struct dg_scpi *to, const char *key, const char *word);
/** A whole part whose value is a number. */
DG_API void dg_state_number(struct dg_scpi *to, const char *key, uint64_t value);
/** A whole part whose value is a number of `digits` hexadecimal digits. */
DG_API void dg_state_hex(struct dg_scpi *to, const char *key, uint64_t value, unsigned digits);
/** Another item of a list of hexadecimal numbers that dg_state_begin() began. */
DG_API void dg_state_item(struct dg_scpi *to, bool *first, uint64_t value, unsigned digits);
/** The end of that list: '-' when it has no item. */
DG_API void dg_state_end(struct dg_scpi *to, bool first);
/** The part `errors`: each bit of `errors` as it reads alone. In line, as an image has one protocol
 * that needs it. */
static inline void dg_state_error_bits(struct dg_scpi *to, uint8_t errors)
{
    bool first = true;
    dg_state_begin(to, "errors");
    for (unsigned bit = 1; bit <= UINT8_MAX; bit <<= 1) {
        if ((errors & bit) != 0) {
            dg_state_item(to, &first, bit, 2);
        }
    }
    dg_state_end(to, first);
}

/* ---------------------------------------------------------------- for commands */

struct dg_encoder;

/** The encoder that a session works on; it may be one of another instrument. */
DG_API struct dg_encoder *dg_control_selected(const struct dg_scpi *self);
/** Raise `code` (enum dg_scpi_error): "NAME: text" with the name of that encoder. */
DG_API void dg_control_refuse(struct dg_scpi *self, int code, const char *text);

#ifdef __cplusplus
}
#endif

#endif
