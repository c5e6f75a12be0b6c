/* SPDX-License-Identifier: MIT */
#include "clocked_wire.h"

/* Edges of the clock in a second. */
static uint32_t edges_of(const struct dg_plan_timing *timing)
{
    return 2u * timing->clock_hz;
}

static uint32_t half_of(const struct dg_plan_timing *timing)
{
    return (uint32_t)(DG_S(1) / edges_of(timing));
}

struct dg_bus_edges_setup lx_clocked_wire_cable(const struct dg_plan_timing *timing)
{
    return (struct dg_bus_edges_setup){
        .size = sizeof(struct dg_bus_edges_setup),
        .there_ns = timing->line_delay_ns,
        .back_ns = timing->line_delay_ns,
        .period_ns = 2u * half_of(timing),
    };
}

void lx_clocked_wire_init(struct lx_clocked_wire *self, struct lx_clocked *line,
                          const struct dg_plan_timing *timing, dg_ns now)
{
    *self = (struct lx_clocked_wire){
        .line = line,
        .half_ns = half_of(timing),
        .rest = (uint32_t)(DG_S(1) % edges_of(timing)),
        .edges_per_s = edges_of(timing),
        .now = now,
        .way_ns = 2u * timing->line_delay_ns,
        .compensates = timing->compensate,
    };
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

void lx_clocked_wire_edge(struct lx_clocked_wire *self, bool level)
{
    self->now = next_edge(self);
    (void)dg_bus_edge(self->line->bus, self->now, level);
}

bool lx_clocked_wire_bit(struct lx_clocked_wire *self)
{
    lx_clocked_wire_edge(self, false);
    lx_clocked_wire_edge(self, true);
    return dg_bus_edges_data(self->line->bus, self->now + self->delay + self->half_ns);
}

void lx_clocked_wire_pause(struct lx_clocked_wire *self, dg_ns now)
{
    self->now = now > self->now ? now : self->now;
    lx_clocked_look(self->line, self->now);
}
