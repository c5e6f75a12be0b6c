/* SPDX-License-Identifier: MIT */
/*
 * Clocked lines, an edge or a frame at a time: apart, so that who has none does not link this.
 */
#include "host_private.h"

#include <string.h>

int dg_host_clock(struct dg_host *self, uint64_t now, bool level)
{
    if (self->refs.wire->clock == NULL) {
        return DG_HOST_ERR_WIRE;
    }
    if (!self->made) {
        return DG_HOST_ERR_STATE;
    }
    if (dg_host_next(self) <= now) {
        dg_host_run(self, now);
    }
    self->line.now = now > self->line.now ? now : self->line.now;
    (void)self->refs.wire->clock(&self->line, self->line.now, level);
    dg_host_serve(self);
    return self->line.level ? 1 : 0;
}

int dg_host_behind(struct dg_host *self, uint64_t now, bool level)
{
    if (!self->refs.wire->chains) {
        return DG_HOST_ERR_WIRE;
    }
    if (!self->made) {
        return DG_HOST_ERR_STATE;
    }
    dg_host_run(self, now);
    self->line.behind = level;
    self->line.chained = true;
    dg_host_look_at_level(self);
    return self->line.level ? 1 : 0;
}

const char *dg_host_hint(struct dg_host *self, uint64_t now, uint64_t *due)
{
    /* As long as the neighbour is silent, too, it is the neighbour that says so. */
    const bool last = !self->line.chained || self->line.behind;

    *due = DG_HOST_NEVER;
    return self->refs.wire->hint != NULL && dg_host_powered(self) && last
               ? self->refs.wire->hint(&self->line, now, due)
               : NULL;
}

int dg_host_latched(const struct dg_host *self, uint64_t *at, uint64_t *counts)
{
    if (self->refs.wire->latched == NULL) {
        return DG_HOST_ERR_WIRE;
    }
    if (!self->made || self->line.latched == 0) {
        return DG_HOST_ERR_STATE;
    }
    *at = self->line.latched;
    *counts = self->refs.wire->latched(&self->line);
    return DG_HOST_OK;
}

int dg_host_frame(struct dg_host *self, uint64_t now, struct dg_host_frame *to)
{
    int result = DG_HOST_ERR_WIRE;

    if (self->refs.wire->frame == NULL ||
        dg_host_line_at(self, self->refs.wire, now, &result) == NULL) {
        return result;
    }
    memset(to, 0, sizeof *to);
    result = self->refs.wire->frame(&self->line, to);
    dg_host_line_done(self);
    to->end = self->line.now;
    return result;
}
