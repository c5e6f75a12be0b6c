/* SPDX-License-Identifier: MIT */
/*
 *   stir        to(now)               to(now)
 *     v           v                     v
 *   --|--x--|--o--|--o--|--o--|--x--|--x--|--   x run, o counted
 *        ^ something may come of what was done: run
 *                              ^ the last one before a look: it latches
 */
#include "modbus_time.h"

void lx_ring_time_init(struct lx_ring_time *self, const struct lx_ring_time_setup *setup)
{
    *self = (struct lx_ring_time){.setup = *setup, .next = DG_NEVER, .stirred = true};
}

/* The cycle that is next, as if it were `at`. */
static void run_cycles(struct lx_ring_time *self, dg_ns at)
{
    lx_map_tick(self->setup.map, at);
    self->setup.drive(self->setup.ctx, at);
    self->next += self->setup.period;
    self->stirred = false;
}

/* Cycles before it, from the next one on, only count and latch. */
static dg_ns quiet(const struct lx_ring_time *self)
{
    const struct lx_map *map = self->setup.map;
    return self->stirred ? self->next
                         : dg_earliest(dg_ring_quiet(map->ring->bus), lx_map_quiet(map));
}

/* All but the last one of those that only count and latch until `end`. */
static void skip_cycles(struct lx_ring_time *self, dg_ns end)
{
    const dg_ns until = dg_earliest(quiet(self), end);
    if (until <= self->next) {
        return;
    }
    const dg_ns n = (until - 1u - self->next) / self->setup.period;
    dg_ring_skip(self->setup.map->ring->bus, (uint32_t)n); /* counters wrap, as one by one */
    self->next += n * self->setup.period;
}

void lx_ring_time_to(struct lx_ring_time *self, dg_ns now)
{
    while (!self->watched && self->next <= now) {
        run_cycles(self, self->next);
        skip_cycles(self, dg_after(now, 1));
    }
}

void lx_ring_time_stir(struct lx_ring_time *self)
{
    self->stirred = true;
}

void lx_ring_time_watch(struct lx_ring_time *self, bool watched, dg_ns now)
{
    lx_ring_time_to(self, now);
    self->watched = watched;
}

void lx_ring_time_unwatch(struct lx_ring_time *self)
{
    self->watched = false;
}

dg_ns lx_ring_time_next(const struct lx_ring_time *self)
{
    const dg_ns until = quiet(self);
    if (self->next == DG_NEVER) {
        return 0; /* it has not begun */
    }
    if (self->watched || until <= self->next) {
        return self->next;
    }
    if (until == DG_NEVER) {
        return DG_NEVER;
    }
    const dg_ns n = (until - self->next + self->setup.period - 1u) / self->setup.period;
    return self->next + n * self->setup.period;
}

/* Late, a watched ring leaves cycles out; it does not make up for them. */
static void leave_out(struct lx_ring_time *self, dg_ns now)
{
    const dg_ns missed = dg_elapsed(now, self->next) / self->setup.period;
    self->setup.map->missed += (uint32_t)missed;
    self->next += missed * self->setup.period;
}

void lx_ring_time_due(struct lx_ring_time *self, dg_ns now)
{
    /* The first one is when the loop begins, and never late. */
    self->next = self->next == DG_NEVER ? now : self->next;
    if (!self->watched) {
        lx_ring_time_to(self, now);
    } else if (self->next <= now) {
        leave_out(self, now);
        run_cycles(self, now);
    }
}
