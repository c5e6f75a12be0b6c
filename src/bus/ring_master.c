/* SPDX-License-Identifier: MIT */
/*
 *   stir        to(now)               to(now)
 *     v           v                     v
 *   --|--x--|--o--|--o--|--o--|--x--|--x--|--   x run, o counted
 *        ^ something may come of what was done: run
 *                              ^ the last one before a look: it latches
 */
#include "drehgeber/ring_master.h"

#include <string.h>

#include "ring_private.h"

void dg_ring_master_init(struct dg_ring_master *self, const struct dg_ring_master_setup *setup)
{
    *self = (struct dg_ring_master){.setup = *setup, .next = DG_NEVER, .stirred = true};
}

const uint16_t *dg_ring_master_in(const struct dg_ring_master *self)
{
    return ring_of(self->setup.bus)->setup.in;
}

/* ------------------------------------------------------------ the watchdog */

void dg_ring_master_feed(struct dg_ring_master *self, dg_ns now)
{
    if (!self->watchdog.fired) {
        self->watchdog.fed = now;
    }
}

void dg_ring_master_start(struct dg_ring_master *self, dg_ns now)
{
    self->watchdog.armed = true;
    self->watchdog.fired = false;
    self->watchdog.fed = now;
    self->stopped = false;
}

void dg_ring_master_reset(struct dg_ring_master *self)
{
    self->watchdog.fired = false;
    self->watchdog.armed = false;
    self->stopped = false;
}

static bool guards(const struct dg_ring_watchdog *self)
{
    return self->armed && !self->fired && self->time_ms != 0;
}

/* Before this time it finds nothing to do, if nobody feeds it. */
static dg_ns fires_at(const struct dg_ring_watchdog *self)
{
    return guards(self) ? dg_after(self->fed, DG_MS(self->time_ms) + 1u) : DG_NEVER;
}

static void fire_watchdog(struct dg_ring_master *self, dg_ns now)
{
    struct dg_ring_watchdog *watchdog = &self->watchdog;

    if (!guards(watchdog) || dg_elapsed(now, watchdog->fed) <= DG_MS(watchdog->time_ms)) {
        return;
    }
    watchdog->fired = true;
    if (watchdog->fallback == DG_RING_FALLBACK_ZERO) {
        memset(self->setup.out, 0, dg_ring_state(self->setup.bus)->words * sizeof(uint16_t));
    }
    self->stopped = watchdog->fallback == DG_RING_FALLBACK_STOP;
}

/* ------------------------------------------------------------ cycles */

bool dg_ring_master_cycle(struct dg_ring_master *self, dg_ns now)
{
    const struct dg_ring_state *state = dg_ring_state(self->setup.bus);

    fire_watchdog(self, now);
    const struct dg_tap_event event = {
        .at = now,
        .kind = DG_TAP_WORDS,
        .words = {.out = self->setup.out, .count = state->words, .identify = self->stopped},
    };
    (void)dg_bus_rx(self->setup.bus, &event);
    /* A fault may have happened as often as it was to, which nobody hears of. */
    self->bent = self->bent && dg_bus_is_bent(self->setup.bus);
    return !state->dropped;
}

/* The cycle that is next, as if it were `at`. */
static void run_next(struct dg_ring_master *self, dg_ns at)
{
    (void)dg_ring_master_cycle(self, at);
    self->next += self->setup.period;
    self->stirred = false;
}

static bool is_live(const struct dg_ring_master *self)
{
    return self->watched || self->bent;
}

/* Cycles before it, from the next one on, only count and latch. */
static dg_ns quiet_until(const struct dg_ring_master *self)
{
    return self->stirred ? self->next
                         : dg_earliest(dg_ring_quiet(self->setup.bus), fires_at(&self->watchdog));
}

/* All but the last one of those that only count and latch until `end`. */
static void skip_cycles(struct dg_ring_master *self, dg_ns end)
{
    const dg_ns until = dg_earliest(quiet_until(self), end);

    if (until <= self->next) {
        return;
    }
    const dg_ns n = (until - 1u - self->next) / self->setup.period;
    dg_ring_skip(self->setup.bus, (uint32_t)n); /* counters wrap, as one by one */
    self->next += n * self->setup.period;
}

void dg_ring_master_to(struct dg_ring_master *self, dg_ns now)
{
    while (!is_live(self) && self->next <= now) {
        run_next(self, self->next);
        skip_cycles(self, dg_after(now, 1));
    }
}

void dg_ring_master_stir(struct dg_ring_master *self)
{
    self->stirred = true;
}

void dg_ring_master_changed(struct dg_ring_master *self, bool watched, dg_ns now)
{
    dg_ring_master_to(self, now);
    self->watched = watched;
    self->bent = dg_bus_is_bent(self->setup.bus);
    self->stirred = true;
}

dg_ns dg_ring_master_next(const struct dg_ring_master *self)
{
    const dg_ns until = quiet_until(self);

    if (self->next == DG_NEVER) {
        return 0; /* it has not begun */
    }
    if (is_live(self) || until <= self->next) {
        return self->next;
    }
    if (until == DG_NEVER) {
        return DG_NEVER;
    }
    const dg_ns n = (until - self->next + self->setup.period - 1u) / self->setup.period;
    return self->next + n * self->setup.period;
}

/* Late, a watched ring leaves cycles out; it does not make up for them. */
static void leave_out(struct dg_ring_master *self, dg_ns now)
{
    const dg_ns missed = dg_elapsed(now, self->next) / self->setup.period;

    self->missed += (uint32_t)missed;
    self->next += missed * self->setup.period;
}

void dg_ring_master_due(struct dg_ring_master *self, dg_ns now)
{
    /* The first one is when the host begins, and never late. */
    self->next = self->next == DG_NEVER ? now : self->next;
    if (!is_live(self)) {
        dg_ring_master_to(self, now);
    } else if (self->next <= now) {
        leave_out(self, now);
        run_next(self, now);
    }
}
