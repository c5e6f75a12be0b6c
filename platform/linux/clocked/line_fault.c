/* SPDX-License-Identifier: MIT */
#include "line_fault.h"

#include <stddef.h>

#define HELD (LX_LINE_FAULT_DELAY_MAX + 1u)

static uint8_t delay_clocks(dg_ns delay, dg_ns period)
{
    const dg_ns clocks = delay / period;
    if (clocks > LX_LINE_FAULT_DELAY_MAX) {
        return LX_LINE_FAULT_DELAY_MAX;
    }
    return clocks == 0 ? 1u : (uint8_t)clocks;
}

static void forget(struct lx_line_fault *self)
{
    *self = (struct lx_line_fault){.frame = self->frame, .faults = self->faults};
}

void lx_line_fault_begin(struct lx_line_fault *self, dg_ns period)
{
    struct dg_faults *faults = self->faults;
    self->active = faults != NULL && faults->wire != 0;
    if (!self->active) {
        return;
    }
    forget(self);
    self->active = true;
    self->started = !self->frame.waits;
    self->held[0] = !self->frame.waits;
    self->cut = dg_fault_wire_active(faults, DG_WIRE_BREAK);
    self->cut = dg_fault_wire_takes(faults, DG_WIRE_DROP) || self->cut;
    if (dg_fault_wire_takes(faults, DG_WIRE_DELAY)) {
        self->delay = delay_clocks(self->frame.delay, period);
    }
    if (dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
        const uint32_t first = self->frame.ahead + 1u;
        self->flip = (uint8_t)(first + dg_fault_pick(faults, self->frame.bits));
    }
}

void lx_line_fault_kill(struct lx_line_fault *self)
{
    forget(self);
    self->active = true;
    self->cut = true;
}

void lx_line_fault_end(struct lx_line_fault *self)
{
    const bool cut = self->faults != NULL && dg_fault_wire_active(self->faults, DG_WIRE_BREAK);
    if (cut || self->active) {
        forget(self);
        self->active = cut;
        self->cut = cut;
    }
}

static bool flips(const struct lx_line_fault *self)
{
    return self->flip != 0 && self->bit == self->flip;
}

bool lx_line_fault_level(const struct lx_line_fault *self, bool raw)
{
    if (!self->active) {
        return raw;
    }
    if (self->cut) {
        return self->frame.open;
    }
    if (self->delay == 0 || self->clocks < self->frame.lead) {
        return raw != flips(self);
    }
    const unsigned clock = self->clocks - self->delay;
    return self->clocks < self->frame.lead + self->delay ? !self->frame.waits
                                                         : self->held[clock % HELD];
}

void lx_line_fault_advance(struct lx_line_fault *self, bool raw)
{
    if (!self->active) {
        return;
    }
    self->clocks++;
    if (self->started) {
        self->bit++;
    } else {
        self->started = self->clocks > self->frame.lead && raw;
    }
    self->held[self->clocks % HELD] = raw != flips(self);
}
