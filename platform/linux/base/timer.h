/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A deadline on the event loop, and the clock it is told in.
 */
#ifndef DREHGEBER_LINUX_TIMER_H
#define DREHGEBER_LINUX_TIMER_H

#include <stdbool.h>
#include <systemd/sd-event.h>

#include "drehgeber/time.h"

/** The monotonic clock. */
dg_ns lx_now(void);

/** One deadline. */
struct lx_timer {
    sd_event_source *source;
    void (*due)(void *ctx, dg_ns now); /**< called once at the deadline, `now` never before it */
    void *ctx;
    dg_ns at;
    bool overdue; /**< it was when it was set: then it waits for its turn */
};

/** Make a timer that waits for nothing. @return 0 or a negative errno */
int lx_timer_open(struct lx_timer *self, sd_event *event, void (*due)(void *ctx, dg_ns now),
                  void *ctx);

/** Wait for `at` instead of what it waited for; DG_NEVER: for nothing. A deadline comes before more
 * input, so that a flood does not hold it up; one that is over already comes in turn with it, so
 * that somebody who is always late does not hold up the rest. */
void lx_timer_at(struct lx_timer *self, dg_ns at);

/** Take it off the loop; also when it was never opened. */
void lx_timer_close(struct lx_timer *self);

#endif
