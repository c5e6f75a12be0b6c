/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Looking at a wire: every bus tells its tap what goes over it, and whoever wants to know (a trace
 * file, the decoder behind --verbose and TRACe:LAST?) listens. Without a listener it costs one
 * comparison.
 */
#ifndef DREHGEBER_LINUX_TAP_H
#define DREHGEBER_LINUX_TAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/canopen.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/time.h"

/** What happened on a wire. */
enum lx_tap_kind {
    LX_TAP_CHARACTER, /**< RS485: a character, at the end of its stop bit */
    LX_TAP_FRAME,     /**< CAN */
    LX_TAP_LEVELS,    /**< a clocked line: clock and data from this moment on */
    LX_TAP_WORDS,     /**< INTERBUS: a data cycle */
    LX_TAP_NOTE,      /**< something in words: what a BiSS frame meant, an ID cycle, power off */
    LX_TAP_SINCOS,    /**< RS485: sine and cosine of an encoder, for those who ask for it only */
};

/** An event. Pointers are valid during the call. */
struct lx_tap_event {
    dg_ns at;
    enum lx_tap_kind kind;
    bool ours; /**< an encoder sent it, not the master */
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
            uint16_t count; /**< words of either image */
            bool valid;     /**< the cycle was completed */
        } words;
        const char *note;
        struct {
            size_t encoder; /**< index in lx_tap.encoders */
            struct dg_hf_sincos lines;
        } sincos;
    };
};

/** A listener. Listeners are called in the order they came. */
struct lx_tap_listener {
    void (*event)(void *ctx, const struct lx_tap_event *event);
    void *ctx;
    bool sincos;                  /**< asks for LX_TAP_SINCOS */
    struct lx_tap_listener *next; /**< the tap's */
};

/** A tap. All zero has no listener. */
struct lx_tap {
    struct lx_tap_listener *first;
    const char *const *encoders; /**< names of those whose sine and cosine can be asked for */
    size_t encoder_count;
};

/** Whether anybody listens; buses may save themselves the trouble when not. */
static inline bool lx_tap_on(const struct lx_tap *self)
{
    return self->first != NULL;
}

/** Whether anybody asks for sine and cosine. */
bool lx_tap_asked(const struct lx_tap *self);

/** Tell all listeners. */
void lx_tap_tell(const struct lx_tap *self, const struct lx_tap_event *event);

/** Listen, not to be moved while it does; stop, also when it does not listen. */
void lx_tap_add(struct lx_tap *self, struct lx_tap_listener *listener);
void lx_tap_remove(struct lx_tap *self, struct lx_tap_listener *listener);

#endif
