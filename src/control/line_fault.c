/* SPDX-License-Identifier: MIT */
/*
 * Faults of a clocked line, behind its encoder's driver.
 *
 *   clock    _|1|_|2|_|3|_|4|_|5|_       lead 2, delayed by 2 clocks:
 *   raw      ---------___S d0  d1        held by clock, and shown two clocks later
 *   bent     ---------_______S d0
 */
#include "drehgeber/line_fault.h"

#include <stddef.h>

#define HELD (DG_LINE_FAULT_DELAY_MAX + 1u)

static uint16_t delay_clocks(dg_ns delay, dg_ns period)
{
    const dg_ns clocks = delay / (period != 0 ? period : 1u);

    if (clocks > DG_LINE_FAULT_DELAY_MAX) {
        return DG_LINE_FAULT_DELAY_MAX;
    }
    return clocks == 0 ? 1u : (uint16_t)clocks;
}

static void hold_level(struct dg_line_fault *self, bool level)
{
    const unsigned place = self->clocks % HELD;
    const unsigned bit = 1u << place % 8u;
    const unsigned others = self->held[place / 8u] & ~bit;

    self->held[place / 8u] = (uint8_t)(others | (level ? bit : 0u));
}

static bool held(const struct dg_line_fault *self, unsigned clock)
{
    const unsigned byte = self->held[clock % HELD / 8u];

    return (byte >> clock % 8u & 1u) != 0;
}

static void forget_levels(struct dg_line_fault *self)
{
    *self = (struct dg_line_fault){.frame = self->frame, .faults = self->faults};
}

void dg_line_fault_init(struct dg_line_fault *self, const struct dg_instrument *instrument,
                        const void *device, struct dg_faults *faults)
{
    *self = (struct dg_line_fault){.faults = faults};
    instrument->line_frame(device, &self->frame);
    self->frame.delay = (dg_ns)dg_fault_wire_value(instrument, DG_WIRE_DELAY);
}

void dg_line_fault_begin(struct dg_line_fault *self)
{
    struct dg_faults *faults = self->faults;

    self->active = faults != NULL && faults->wire != 0;
    if (!self->active) {
        return;
    }
    forget_levels(self);
    self->active = true;
    self->started = !self->frame.waits;
    hold_level(self, !self->frame.waits);
    self->cut = dg_fault_wire_active(faults, DG_WIRE_BREAK);
    self->cut = dg_fault_wire_takes(faults, DG_WIRE_DROP) || self->cut;
    self->late = dg_fault_wire_takes(faults, DG_WIRE_DELAY);
    if (dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
        const uint32_t first = self->frame.ahead + 1u;
        self->flip = (uint8_t)(first + dg_fault_pick(faults, self->frame.bits));
    }
}

void dg_line_fault_kill(struct dg_line_fault *self)
{
    forget_levels(self);
    self->active = true;
    self->cut = true;
}

void dg_line_fault_end(struct dg_line_fault *self)
{
    const bool cut = self->faults != NULL && dg_fault_wire_active(self->faults, DG_WIRE_BREAK);

    if (cut || self->active) {
        forget_levels(self);
        self->active = cut;
        self->cut = cut;
    }
}

static bool flips(const struct dg_line_fault *self)
{
    return self->flip != 0 && self->bit == self->flip;
}

bool dg_line_fault_level(const struct dg_line_fault *self, bool raw)
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
    return self->clocks < self->frame.lead + self->delay
               ? !self->frame.waits
               : held(self, (unsigned)self->clocks - self->delay);
}

void dg_line_fault_advance(struct dg_line_fault *self, bool raw, dg_ns period)
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
    if (self->late && self->delay == 0 && self->clocks >= self->frame.lead) {
        self->delay = delay_clocks(self->frame.delay, period);
    }
    hold_level(self, raw != flips(self));
}
