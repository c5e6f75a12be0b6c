/* SPDX-License-Identifier: MIT */
/*
 * One timer source for each deadline; off, it costs nothing and wakes nobody. In virtual time there
 * are none: who waits is in a list, and time goes from one to the next as soon as all else is done.
 */
#define _GNU_SOURCE
#include "timer.h"

#include <time.h>

#define ACCURACY_US 1u
/* Of virtual time: always the same, so that what goes by it is, and not 0, which is never. */
#define BEGAN DG_S(1)

/* Time is one for the process, as the machine's clock is: the only state here that is nobody's. */
static struct {
    bool own;
    dg_ns now;
    struct lx_timer *waiting; /* in the order they asked */
} virtual_;

dg_ns lx_now(void)
{
    return virtual_.own ? virtual_.now : lx_real_now();
}

dg_ns lx_real_now(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return DG_S(now.tv_sec) + (dg_ns)now.tv_nsec;
}

/* --- virtual time --- */

void lx_time_own(void)
{
    virtual_.now = BEGAN;
    virtual_.own = true;
}

uint64_t lx_time_of_day(void)
{
    struct timespec now;
    if (virtual_.own) {
        return virtual_.now - BEGAN;
    }
    (void)clock_gettime(CLOCK_REALTIME, &now);
    return DG_S(now.tv_sec) + (uint64_t)now.tv_nsec;
}

static void leave(struct lx_timer *self)
{
    struct lx_timer **link = &virtual_.waiting;
    while (*link != NULL && *link != self) {
        link = &(*link)->next;
    }
    if (*link != NULL) {
        *link = self->next;
    }
    self->next = NULL;
}

static void join(struct lx_timer *self)
{
    struct lx_timer **link = &virtual_.waiting;
    while (*link != NULL) {
        link = &(*link)->next;
    }
    *link = self;
}

static struct lx_timer *first(void)
{
    struct lx_timer *found = virtual_.waiting;
    for (struct lx_timer *timer = found; timer != NULL; timer = timer->next) {
        found = timer->at < found->at ? timer : found;
    }
    return found;
}

bool lx_time_pass(dg_ns end)
{
    struct lx_timer *timer = first();
    if (timer == NULL || timer->at > end) {
        virtual_.now = end;
        return false;
    }
    virtual_.now = timer->at > virtual_.now ? timer->at : virtual_.now;
    leave(timer);
    timer->at = DG_NEVER;
    timer->due(timer->ctx, virtual_.now);
    return true;
}

/* --- timers --- */

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
    if (virtual_.own) {
        return 0;
    }
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
    if (virtual_.own) {
        leave(self);
        if (at != DG_NEVER) {
            join(self);
        }
        return;
    }
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
    leave(self);
    self->source = sd_event_source_disable_unref(self->source);
}
