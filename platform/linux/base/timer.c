/* SPDX-License-Identifier: MIT */
/*
 * One timer source for each deadline; off, it costs nothing and wakes nobody. In virtual time there
 * are none: who waits is in a heap, and time goes from one to the next as soon as all else is done.
 */
#define _GNU_SOURCE
#include "timer.h"

#include <errno.h>
#include <stdlib.h>
#include <time.h>

#define ACCURACY_US 1u
/* Of virtual time: always the same, so that what goes by it is, and not 0, which is never. */
#define BEGAN DG_S(1)

/* Time is one for the process, as the machine's clock is: the only state here that is nobody's. */
static struct {
    bool own;
    dg_ns now;
    struct lx_timer **waiting; /* owned: a heap, from 1 on; [n / 2] goes before [n] */
    size_t count;              /* that wait */
    size_t open;               /* that could */
    size_t capacity;           /* for so many there is room */
    uint64_t turn;
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

static bool goes_before(const struct lx_timer *a, const struct lx_timer *b)
{
    return a->at != b->at ? a->at < b->at : a->turn < b->turn;
}

static void put(struct lx_timer *self, size_t place)
{
    virtual_.waiting[place] = self;
    self->place = place;
}

/* `place` is free, and what is before and behind it in order: put it there, or where it belongs. */
static void settle(struct lx_timer *self, size_t place)
{
    struct lx_timer **heap = virtual_.waiting;
    for (; place > 1u && goes_before(self, heap[place / 2u]); place /= 2u) {
        put(heap[place / 2u], place);
    }
    for (size_t next = 2u * place; next <= virtual_.count; next = 2u * place) {
        next += next < virtual_.count && goes_before(heap[next + 1u], heap[next]) ? 1u : 0u;
        if (!goes_before(heap[next], self)) {
            break;
        }
        put(heap[next], place);
        place = next;
    }
    put(self, place);
}

static void leave(struct lx_timer *self)
{
    const size_t place = self->place;
    if (place == 0) {
        return;
    }
    struct lx_timer *last = virtual_.waiting[virtual_.count--];
    self->place = 0;
    if (last != self) {
        settle(last, place);
    }
}

static void join(struct lx_timer *self)
{
    self->turn = virtual_.turn++;
    settle(self, ++virtual_.count);
}

/* Room for all that are open: who asks later does not have to be told that there is none. */
static int make_room(void)
{
    if (virtual_.open == virtual_.capacity) {
        const size_t capacity = virtual_.capacity == 0 ? 64u : 2u * virtual_.capacity;
        struct lx_timer **waiting =
            reallocarray(virtual_.waiting, capacity + 1u, sizeof(struct lx_timer *));
        if (waiting == NULL) {
            return -ENOMEM;
        }
        virtual_.waiting = waiting;
        virtual_.capacity = capacity;
    }
    virtual_.open++;
    return 0;
}

static void give_back(void)
{
    if (--virtual_.open == 0) {
        free(virtual_.waiting);
        virtual_.waiting = NULL;
        virtual_.capacity = 0;
    }
}

bool lx_time_pass(dg_ns end)
{
    struct lx_timer *timer = virtual_.count > 0 ? virtual_.waiting[1] : NULL;
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
        self->virtual_ = make_room() == 0;
        return self->virtual_ ? 0 : -ENOMEM;
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
    if (self->virtual_) {
        self->virtual_ = false;
        give_back();
    }
    self->source = sd_event_source_disable_unref(self->source);
}
