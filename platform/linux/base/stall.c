/* SPDX-License-Identifier: MIT */
/*
 *   wait | round: one handler | wait ............ | round
 *        ^ woke               ^ before_wait()     ^ woke
 *
 * A long round counts when something is ready behind it: input that came meanwhile, or a deadline
 * that was waited for. A deadline that the round itself has set is not among it, as its timer is
 * set after before_wait(): an encoder that is slow with its own memory keeps nobody waiting.
 *
 * A stop is told by the signal that ends it. All that is known of its length is that it was within
 * the wait, or the one before: what had come when it began may be served first.
 */
#define _GNU_SOURCE
#include "stall.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>

#include "timer.h"

/* When the loop woke last. */
static dg_ns woke(const struct lx_stall *self)
{
    uint64_t us = 0;
    (void)sd_event_now(self->event, CLOCK_MONOTONIC, &us);
    return DG_US(us);
}

/* The loop's own epoll descriptor is readable when a source is. */
static bool something_is_ready(const struct lx_stall *self)
{
    struct pollfd loop = {.fd = sd_event_get_fd(self->event), .events = POLLIN};
    return poll(&loop, 1, 0) > 0;
}

static int before_wait(sd_event_source *source, void *ctx)
{
    struct lx_stall *self = ctx;
    const dg_ns began = woke(self);
    const dg_ns took = dg_elapsed(lx_real_now(), began);
    (void)source;
    if (began == self->woke) {
        return 0; /* no round: a stop has interrupted the wait, which goes on */
    }
    self->told = took > LX_STALL_AFTER && something_is_ready(self);
    if (self->told) {
        self->held_up(self->ctx, took);
    }
    self->waited = dg_elapsed(began, self->waits);
    self->woke = began;
    self->waits = lx_real_now();
    return 0;
}

static int on_continued(sd_event_source *source, const struct signalfd_siginfo *info, void *ctx)
{
    struct lx_stall *self = ctx;
    (void)source;
    (void)info;
    const bool long_enough =
        dg_elapsed(woke(self), self->waits) > LX_STALL_AFTER || self->waited > LX_STALL_AFTER;
    if (long_enough && !self->told) {
        self->held_up(self->ctx, DG_NEVER);
    }
    return 0;
}

static int take_signal(struct lx_stall *self)
{
    sigset_t continued;
    (void)sigemptyset(&continued);
    (void)sigaddset(&continued, SIGCONT);
    if (sigprocmask(SIG_BLOCK, &continued, NULL) != 0) {
        return -errno;
    }
    return sd_event_add_signal(self->event, &self->continued, SIGCONT, on_continued, self);
}

int lx_stall_open(struct lx_stall *self, sd_event *event, void (*held_up)(void *ctx, dg_ns by),
                  void *ctx)
{
    *self =
        (struct lx_stall){.event = event, .held_up = held_up, .ctx = ctx, .waits = lx_real_now()};
    int result = take_signal(self);
    if (result >= 0) {
        result = sd_event_source_set_prepare(self->continued, before_wait);
    }
    if (result >= 0) { /* before anything that may ask for the count */
        result = sd_event_source_set_priority(self->continued, SD_EVENT_PRIORITY_IMPORTANT - 1);
    }
    return result < 0 ? result : 0;
}

void lx_stall_close(struct lx_stall *self)
{
    self->continued = sd_event_source_disable_unref(self->continued);
}
