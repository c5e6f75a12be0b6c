/* SPDX-License-Identifier: MIT */
/*
 * An edge of the clock is taken at the encoders' end at once, with the time at which it gets there;
 * what it does to the data line is then on its way back.
 *
 *   master === clock ==(delay)==> encoders
 *          <==(delay)=== data ===
 */
#include "clocked_wire.h"

void lx_clocked_wire_init(struct lx_clocked_wire *self, struct lx_clocked *line,
                          const struct lx_clocked_timing *timing, dg_ns now)
{
    const uint32_t edges = 2u * timing->clock_hz; /* in a second */
    *self = (struct lx_clocked_wire){
        .line = line,
        .half_ns = (uint32_t)(DG_S(1) / edges),
        .rest = (uint32_t)(DG_S(1) % edges),
        .edges_per_s = edges,
        .now = now,
        .clock = true,
        .data = line->ops->level(line),
        .compensates = timing->compensate,
    };
    line->period = (dg_ns)2 * self->half_ns;
    lx_cable_init(&self->cable, timing->line_delay_ns, self->data);
}

/* The next edge's time. Whole nanoseconds, and yet the clock is right on average. */
static dg_ns next_edge(struct lx_clocked_wire *self)
{
    const dg_ns at = self->now + self->half_ns;
    self->owed += self->rest;
    if (self->owed < self->edges_per_s) {
        return at;
    }
    self->owed -= self->edges_per_s;
    return at + 1u;
}

/* The levels from `at` on, as far as they are new. */
static void record(struct lx_clocked_wire *self, dg_ns at, bool clock, bool data)
{
    const bool news = clock != self->clock || data != self->data;
    self->clock = clock;
    self->data = data;
    if (news && self->levels != NULL) {
        self->levels(self->ctx, at, clock, data);
    }
}

/* What gets to the master up to `until`. */
static void arrive(struct lx_clocked_wire *self, dg_ns until)
{
    struct lx_cable_change change;
    while (self->cable.count > 0 && lx_cable_take(&self->cable, until, &change)) {
        record(self, change.at, self->clock, change.level);
    }
}

/* Deadlines at the encoders' end up to `now`, each at its moment. */
static void run_encoders(struct lx_clocked_wire *self, dg_ns now)
{
    struct lx_clocked *line = self->line;
    dg_ns due = line->ops->step(line, 0);
    while (due <= now && due != DG_NEVER) {
        const dg_ns next = line->ops->step(line, due);
        lx_cable_put(&self->cable, due, line->ops->level(line));
        due = next;
    }
}

void lx_clocked_wire_edge(struct lx_clocked_wire *self, bool level)
{
    const dg_ns now = next_edge(self);
    const dg_ns there = now + self->cable.delay;
    arrive(self, now - 1u);
    self->now = now;
    run_encoders(self, there);
    lx_cable_put(&self->cable, there, self->line->ops->edge(self->line, there, level));
    /* Without delay the answer comes at once: one event for both. */
    struct lx_cable_change change = {.level = self->data};
    while (lx_cable_take(&self->cable, now, &change)) {
    }
    record(self, now, level, change.level);
}

bool lx_clocked_wire_bit(struct lx_clocked_wire *self)
{
    lx_clocked_wire_edge(self, false);
    lx_clocked_wire_edge(self, true);
    return lx_cable_level(&self->cable, self->now + self->delay + self->half_ns);
}

void lx_clocked_wire_pause(struct lx_clocked_wire *self, dg_ns now)
{
    struct lx_clocked *line = self->line;
    now = now > self->now ? now : self->now;
    run_encoders(self, now);
    line->ops->settle(line);
    lx_cable_put(&self->cable, now, line->ops->level(line));
    arrive(self, now);
    self->now = now;
}
