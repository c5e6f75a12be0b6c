/* SPDX-License-Identifier: MIT */
#include "edges_cable.h"

void dg_bus_cable_init(struct dg_bus_cable *self, uint32_t back, bool level)
{
    *self = (struct dg_bus_cable){.back = back, .sent = level, .level = level};
}

static struct dg_bus_cable_change *nth(struct dg_bus_cable *self, unsigned n)
{
    return &self->coming[(self->first + n) % DG_BUS_CABLE_CHANGES];
}

void dg_bus_cable_put(struct dg_bus_cable *self, dg_ns now, bool level)
{
    dg_ns at = dg_after(now, self->back);

    if (level == self->sent) {
        return;
    }
    self->sent = level;
    /* The encoders' end is ahead of the master's by the way there: what is done to them at the
       master's time must not overtake their answer to an edge. */
    if (self->count > 0 && nth(self, self->count - 1u)->at > at) {
        at = nth(self, self->count - 1u)->at;
    }
    self->fell = level ? self->fell : at;
    /* Only power that is switched in no time fills it: of that the last level counts. */
    if (self->count == DG_BUS_CABLE_CHANGES) {
        self->count--;
    }
    *nth(self, self->count++) = (struct dg_bus_cable_change){at, level};
}

bool dg_bus_cable_take(struct dg_bus_cable *self, dg_ns until, struct dg_bus_cable_change *change)
{
    if (self->count == 0 || self->coming[self->first].at > until) {
        return false;
    }
    *change = self->coming[self->first];
    self->level = change->level;
    self->first = (uint16_t)((self->first + 1u) % DG_BUS_CABLE_CHANGES);
    self->count--;
    return true;
}

bool dg_bus_cable_level(const struct dg_bus_cable *self, dg_ns at)
{
    bool level = self->level;

    for (unsigned i = 0; i < self->count; i++) {
        const struct dg_bus_cable_change *change =
            &self->coming[(self->first + i) % DG_BUS_CABLE_CHANGES];
        if (change->at > at) {
            break;
        }
        level = change->level;
    }
    return level;
}
