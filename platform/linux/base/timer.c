/* SPDX-License-Identifier: MIT */
/* One timer source for each deadline; off, it costs nothing and wakes nobody. */
#define _GNU_SOURCE
#include "timer.h"

#include <time.h>

#define ACCURACY_US 1u

dg_ns lx_now(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return DG_S(now.tv_sec) + (dg_ns)now.tv_nsec;
}

static int on_time(sd_event_source *source, uint64_t usec, void *ctx)
{
    struct lx_timer *self = ctx;
    (void)source;
    (void)usec;
    self->at = DG_NEVER;
    self->due(self->ctx, lx_now());
    return 0;
}

int lx_timer_open(struct lx_timer *self, sd_event *event, void (*due)(void *ctx, dg_ns now),
                  void *ctx)
{
    *self = (struct lx_timer){.due = due, .ctx = ctx, .at = DG_NEVER};
    int result =
        sd_event_add_time(event, &self->source, CLOCK_MONOTONIC, 0, ACCURACY_US, on_time, self);
    if (result >= 0) {
        result = sd_event_source_set_enabled(self->source, SD_EVENT_OFF);
    }
    if (result >= 0) {
        result = sd_event_source_set_priority(self->source, SD_EVENT_PRIORITY_IMPORTANT);
    }
    return result;
}

static void set_turn(struct lx_timer *self, bool overdue)
{
    if (overdue != self->overdue) {
        self->overdue = overdue;
        (void)sd_event_source_set_priority(self->source, overdue ? SD_EVENT_PRIORITY_NORMAL
                                                                 : SD_EVENT_PRIORITY_IMPORTANT);
    }
}

void lx_timer_at(struct lx_timer *self, dg_ns at)
{
    if (at == self->at) {
        return;
    }
    self->at = at;
    if (at == DG_NEVER) {
        (void)sd_event_source_set_enabled(self->source, SD_EVENT_OFF);
        return;
    }
    set_turn(self, at <= lx_now());
    /* Rounded up: never early. */
    (void)sd_event_source_set_time(self->source, at / 1000u + (at % 1000u != 0 ? 1u : 0u));
    (void)sd_event_source_set_enabled(self->source, SD_EVENT_ONESHOT);
}

void lx_timer_close(struct lx_timer *self)
{
    self->source = sd_event_source_disable_unref(self->source);
}
