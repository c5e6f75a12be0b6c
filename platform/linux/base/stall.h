/* SPDX-License-Identifier: MIT */
/**
 * @file
 * When the whole process was held up: stopped, or in a call that did not return. Deadlines are
 * counted where they are missed; input has no time stamp, so whether it has waited is seen here. An
 * idle loop is not woken for that.
 */
#ifndef DREHGEBER_LINUX_STALL_H
#define DREHGEBER_LINUX_STALL_H

#include <stdbool.h>
#include <systemd/sd-event.h>

#include "drehgeber/time.h"

/** How long the loop may be away before it counts: the maximum response time of RS485 encoders. */
#define LX_STALL_AFTER DG_MS(10)

/** A loop that is looked after. */
struct lx_stall {
    sd_event *event;
    sd_event_source *continued; /**< SIGCONT; looks before each round's wait, too */
    /** `by`: so long; DG_NEVER: stopped, and nobody knows how long. Never below LX_STALL_AFTER. */
    void (*held_up)(void *ctx, dg_ns by);
    void *ctx;
    dg_ns woke;   /**< when the round before began */
    dg_ns waits;  /**< since when the loop waits */
    dg_ns waited; /**< how long it had waited for the round before */
    bool told;    /**< of the round before */
};

/** Begin; SIGCONT is taken by the loop from now on. @return 0 or a negative errno */
int lx_stall_open(struct lx_stall *self, sd_event *event, void (*held_up)(void *ctx, dg_ns by),
                  void *ctx);

/** End; also when it never began. */
void lx_stall_close(struct lx_stall *self);

#endif
