/* SPDX-License-Identifier: MIT */
#include "cable.h"

void lx_cable_init(struct lx_cable *self, dg_ns delay, bool level)
{
    *self = (struct lx_cable){.delay = delay, .sent = level, .level = level};
}

static struct lx_cable_change *nth(struct lx_cable *self, size_t n)
{
    return &self->coming[(self->first + n) % LX_CABLE_CHANGES];
}

void lx_cable_put(struct lx_cable *self, dg_ns now, bool level)
{
    dg_ns at = dg_after(now, self->delay);

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
    if (self->count == LX_CABLE_CHANGES) {
        self->count--;
    }
    *nth(self, self->count++) = (struct lx_cable_change){at, level};
}

bool lx_cable_take(struct lx_cable *self, dg_ns until, struct lx_cable_change *change)
{
    if (self->count == 0 || self->coming[self->first].at > until) {
        return false;
    }
    *change = self->coming[self->first];
    self->level = change->level;
    self->first = (self->first + 1u) % LX_CABLE_CHANGES;
    self->count--;
    return true;
}

bool lx_cable_level(const struct lx_cable *self, dg_ns at)
{
    bool level = self->level;

    for (size_t i = 0; i < self->count; i++) {
        const struct lx_cable_change *change = &self->coming[(self->first + i) % LX_CABLE_CHANGES];
        if (change->at > at) {
            break;
        }
        level = change->level;
    }
    return level;
}
