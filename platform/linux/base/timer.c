/* SPDX-License-Identifier: MIT */
/*
 * One timer source for each deadline; off, it costs nothing and wakes nobody. In virtual time there
 * are none: who waits is in a heap, and time goes from one to the next as soon as all else is done.
 */
#define _GNU_SOURCE
#include "timer.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define ACCURACY_US 1u
/* Of virtual time: always the same, so that what goes by it is, and not 0, which is never. */
#define BEGAN DG_S(1)

struct lx_strand {
    dg_ns now;
    struct lx_timer **waiting; /* owned: a heap, from 1 on; [n / 2] goes before [n] */
    size_t count;              /* that wait */
    size_t open;               /* that could */
    size_t capacity;           /* for so many there is room */
    uint64_t turn;
};

/* Time is one for the process, as the machine's clock is: the only state here that is nobody's. */
static struct {
    bool own;
    struct lx_strand all;
} virtual_;
/* ... but of a thread that has entered a strand. */
static _Thread_local struct lx_strand *entered;

static struct lx_strand *here(void)
{
    return entered != NULL ? entered : &virtual_.all;
}

dg_ns lx_now(void)
{
    return virtual_.own ? here()->now : lx_real_now();
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
    virtual_.all.now = BEGAN;
    virtual_.own = true;
}

uint64_t lx_time_of_day(void)
{
    struct timespec now;
    if (virtual_.own) {
        return here()->now - BEGAN;
    }
    (void)clock_gettime(CLOCK_REALTIME, &now);
    return DG_S(now.tv_sec) + (uint64_t)now.tv_nsec;
}

static bool fires_before(const struct lx_timer *a, const struct lx_timer *b)
{
    return a->at != b->at ? a->at < b->at : a->turn < b->turn;
}

static void put_timer(struct lx_timer *self, size_t place)
{
    self->strand->waiting[place] = self;
    self->place = place;
}

/* `place` is free, and what is before and behind it in order: put it there, or where it belongs. */
static void settle_timer(struct lx_timer *self, size_t place)
{
    struct lx_timer **heap = self->strand->waiting;
    const size_t count = self->strand->count;
    for (; place > 1u && fires_before(self, heap[place / 2u]); place /= 2u) {
        put_timer(heap[place / 2u], place);
    }
    for (size_t next = 2u * place; next <= count; next = 2u * place) {
        next += next < count && fires_before(heap[next + 1u], heap[next]) ? 1u : 0u;
        if (!fires_before(heap[next], self)) {
            break;
        }
        put_timer(heap[next], place);
        place = next;
    }
    put_timer(self, place);
}

static void leave_strand(struct lx_timer *self)
{
    struct lx_strand *strand = self->strand;
    const size_t place = self->place;
    if (place == 0) {
        return;
    }
    struct lx_timer *last = strand->waiting[strand->count--];
    self->place = 0;
    if (last != self) {
        settle_timer(last, place);
    }
}

static void join_timers(struct lx_timer *self)
{
    self->turn = self->strand->turn++;
    settle_timer(self, ++self->strand->count);
}

/* Room for all that are open: who asks later does not have to be told that there is none. */
static int make_timer_room(struct lx_strand *self)
{
    if (self->open == self->capacity) {
        const size_t capacity = self->capacity == 0 ? 64u : 2u * self->capacity;
        struct lx_timer **waiting =
            reallocarray(self->waiting, capacity + 1u, sizeof(struct lx_timer *));
        if (waiting == NULL) {
            return -ENOMEM;
        }
        self->waiting = waiting;
        self->capacity = capacity;
    }
    self->open++;
    return 0;
}

static void give_back(struct lx_strand *self)
{
    if (--self->open == 0) {
        free(self->waiting);
        self->waiting = NULL;
        self->capacity = 0;
    }
}

bool lx_time_pass(dg_ns end)
{
    struct lx_strand *self = here();
    struct lx_timer *timer = self->count > 0 ? self->waiting[1] : NULL;
    if (timer == NULL || timer->at > end) {
        self->now = end;
        return false;
    }
    self->now = timer->at > self->now ? timer->at : self->now;
    leave_strand(timer);
    timer->at = DG_NEVER;
    timer->due(timer->ctx, self->now);
    return true;
}

/* --- strands --- */

struct lx_strand *lx_strand_new(void)
{
    struct lx_strand *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->now = virtual_.all.now;
    }
    return self;
}

void lx_strand_free(struct lx_strand *self)
{
    free(self);
}

void lx_strand_enter(struct lx_strand *self)
{
    entered = self;
}

dg_ns lx_strand_next(const struct lx_strand *self)
{
    const struct lx_strand *strand = self != NULL ? self : &virtual_.all;
    return strand->count > 0 ? strand->waiting[1]->at : DG_NEVER;
}

void lx_strand_skip(struct lx_strand *self, dg_ns now)
{
    self->now = now;
}

int lx_timer_move(struct lx_timer *self, struct lx_strand *to)
{
    struct lx_strand *from = self->strand;
    struct lx_strand *strand = to != NULL ? to : &virtual_.all;
    const bool waits = self->place != 0;
    if (make_timer_room(strand) != 0) {
        return -ENOMEM;
    }
    leave_strand(self);
    give_back(from);
    self->strand = strand;
    if (waits) {
        join_timers(self);
    }
    return 0;
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
        self->strand = make_timer_room(&virtual_.all) == 0 ? &virtual_.all : NULL;
        return self->strand != NULL ? 0 : -ENOMEM;
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

int lx_timer_make(struct lx_timer *self, sd_event *event, void (*due)(void *ctx, dg_ns now),
                  void *ctx, struct lx_error *error)
{
    const int result = lx_timer_open(self, event, due, ctx);
    return result < 0 ? lx_fail(error, "no timer: %s", strerror(-result)) : 0;
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
        leave_strand(self);
        if (at != DG_NEVER) {
            join_timers(self);
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
    leave_strand(self);
    if (self->strand != NULL) {
        give_back(self->strand);
        self->strand = NULL;
    }
    self->source = sd_event_source_disable_unref(self->source);
}
