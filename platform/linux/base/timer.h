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
#include "error.h"

/** The monotonic clock; in virtual time it stands still but for lx_time_pass(). */
dg_ns lx_now(void);

/** The monotonic clock also then: for what really takes time, a disk, or a stop of this process. */
dg_ns lx_real_now(void);

/** Nanoseconds since 1970; in virtual time since that began, so that what is recorded of it is
 * always the same. */
uint64_t lx_time_of_day(void);

/** Virtual time for the whole process, from now on; before any timer is opened. */
void lx_time_own(void);

/** Virtual time: let it go on to the first deadline that anybody waits for, and call who does, the
 * one who asked first of those at the same moment. @return false: there is none up to `end`, and it
 * is `end` */
bool lx_time_pass(dg_ns end);

/**
 * A strand of virtual time: deadlines that concern nobody but who asked for them. While the
 * process's time stands still, a strand is taken up to it, on any thread; a thread that has entered
 * one has its time, and lx_time_pass() is about its deadlines.
 */
struct lx_strand;

/** At the process's time. @return NULL without memory */
struct lx_strand *lx_strand_new(void);

/** Give it back, when no timer is in it; NULL is fine. */
void lx_strand_free(struct lx_strand *self);

/** This thread has the time of `self` from here on; NULL: that of the process. */
void lx_strand_enter(struct lx_strand *self);

/** The first deadline in it; NULL: of the process itself. DG_NEVER: there is none. */
dg_ns lx_strand_next(const struct lx_strand *self);

/** Nothing in it is due up to `now`, and that is its time. */
void lx_strand_skip(struct lx_strand *self, dg_ns now);

/** One deadline. */
struct lx_timer {
    sd_event_source *source;
    void (*due)(void *ctx, dg_ns now); /**< called once at the deadline, `now` never before it */
    void *ctx;
    dg_ns at;
    struct lx_strand *strand; /**< it was opened in virtual time; NULL: in real time */
    size_t place;  /**< its place among those who wait there, from 1; 0: it does not wait */
    uint64_t turn; /**< whose turn it is at the same moment */
    bool overdue;  /**< it was when it was set: then it waits for its turn */
};

/** Make a timer that waits for nothing. @return 0 or a negative errno */
int lx_timer_open(struct lx_timer *self, sd_event *event, void (*due)(void *ctx, dg_ns now),
                  void *ctx);

/** The same for who tells the user. @return 0, or -1 with `error` */
int lx_timer_make(struct lx_timer *self, sd_event *event, void (*due)(void *ctx, dg_ns now),
                  void *ctx, struct lx_error *error);

/** Wait for `at` instead of what it waited for; DG_NEVER: for nothing. A deadline comes before more
 * input, so that a flood does not hold it up; one that is over already comes in turn with it, so
 * that somebody who is always late does not hold up the rest. */
void lx_timer_at(struct lx_timer *self, dg_ns at);

/** Virtual time: it is in `to` from here on, NULL: in that of the process. @return 0; or a negative
 * errno, then it stays where it was */
int lx_timer_move(struct lx_timer *self, struct lx_strand *to);

/** Take it off the loop; also when it was never opened. */
void lx_timer_close(struct lx_timer *self);

#endif
