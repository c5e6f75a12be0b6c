/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Looking at a wire: every bus tells its tap what goes over it, and whoever wants to know (a trace
 * file, the words of --verbose and TRACe:LAST?) listens. Without a listener it costs one
 * comparison.
 */
#ifndef DREHGEBER_LINUX_TAP_H
#define DREHGEBER_LINUX_TAP_H

#include <stdbool.h>
#include <stddef.h>

#include "drehgeber/tap.h"

/** A listener. Listeners are called in the order they came. */
struct lx_tap_listener {
    void (*event)(void *ctx, const struct dg_tap_event *event);
    void *ctx;
    bool sincos;                  /**< asks for DG_TAP_SINCOS */
    struct lx_tap_listener *next; /**< the tap's */
};

/** A tap. All zero has no listener. */
struct lx_tap {
    struct lx_tap_listener *first;
    const char *const *encoders; /**< names of those whose sine and cosine can be asked for */
    size_t encoder_count;
    uint32_t baud; /**< characters: the fastest data rate that an encoder may have; 0: slow */
};

/** Whether anybody listens; buses may save themselves the trouble when not. */
static inline bool lx_tap_on(const struct lx_tap *self)
{
    return self->first != NULL;
}

/** Whether anybody asks for sine and cosine. */
bool lx_tap_asked(const struct lx_tap *self);

/** Tell all listeners. */
void lx_tap_tell(const struct lx_tap *self, const struct dg_tap_event *event);

/** Listen, not to be moved while it does; stop, also when it does not listen. */
void lx_tap_add(struct lx_tap *self, struct lx_tap_listener *listener);
void lx_tap_remove(struct lx_tap *self, struct lx_tap_listener *listener);

#endif
