/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What goes over a wire, as whoever looks at it is told: traces, --verbose, a page. An event knows
 * its medium and no protocol; what it means in words is each protocol's (words.h).
 */
#ifndef DREHGEBER_TAP_H
#define DREHGEBER_TAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/frame.h"
#include "drehgeber/time.h"

/** What happened on a wire. */
enum dg_tap_kind {
    DG_TAP_CHARACTER, /**< an asynchronous line: a character, at the end of its stop bit */
    DG_TAP_FRAME,     /**< CAN */
    DG_TAP_LEVELS,    /**< a clocked line: clock and data from this moment on */
    DG_TAP_WORDS,     /**< a ring: a data cycle */
    DG_TAP_NOTE,      /**< something in words: what a frame meant, an ID cycle, power off */
    DG_TAP_SINCOS,    /**< sine and cosine of an encoder, for those who ask for it only */
    DG_TAP_KIND_COUNT
};

/** How much what went over a wire matters to whoever reads it. */
enum dg_severity {
    DG_SEVERITY_OK,
    DG_SEVERITY_NOTICE,  /**< the state of an encoder, or of the wire, changes */
    DG_SEVERITY_WARNING, /**< it still works, or nobody understands what was said */
    DG_SEVERITY_ERROR,   /**< something failed, was refused or was damaged */
    DG_SEVERITY_COUNT
};

/** Longest reply in characters. */
#define DG_REPLY_MAX 135u
/** Data cycles of a ring without valid data behind one with a transmission error. */
#define DG_RING_DEAD_CYCLES 5u

/** An event. Pointers are valid during the call. */
struct dg_tap_event {
    dg_ns at;
    enum dg_tap_kind kind;
    bool ours;                 /**< an encoder sent it, not the master */
    enum dg_severity severity; /**< of a note: who makes it knows; of others their words tell */
    union {
        struct {
            uint32_t baud; /**< of the line */
            char parity;   /**< 'N', 'E', 'O' */
            uint8_t byte;
            bool damaged;
        } character;
        struct dg_can_frame frame;
        struct {
            bool clock;
            bool data;
        } levels;
        struct {
            const uint16_t *in;
            const uint16_t *out;
            const uint8_t
                *widths;    /**< words (1, 2) of each device, in ring order; NULL: not known */
            uint16_t count; /**< words of either image */
            bool valid;     /**< the cycle was completed */
            bool identify;  /**< an ID cycle, which moves no words; without `count` of the ring's
                                 words in `out`, or with NULL, who looks is not shown it */
        } words;
        const char *note;
        struct {
            size_t encoder; /**< its place on the wire, from 0 */
            int32_t uv[4];  /**< sin+, sin-, cos+, cos- in microvolts */
        } sincos;
    };
};

#endif
