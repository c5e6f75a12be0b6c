/* SPDX-License-Identifier: MIT */
#include "line_fault.h"

#include <stddef.h>

/* The clock of the Ack. */
#define ACK_CLOCK 2u
/* Bits behind the start bit: CDS is 1, then comes the data. */
#define DATA_FIRST 2u
#define HELD (LX_LINE_FAULT_DELAY_MAX + 1u)

static uint8_t delay_of(dg_ns clock)
{
    const dg_ns delay = (dg_ns)dg_fault_wire_value(&dg_biss_stack, DG_WIRE_DELAY);
    const dg_ns clocks = delay / clock;
    if (clocks > LX_LINE_FAULT_DELAY_MAX) {
        return LX_LINE_FAULT_DELAY_MAX;
    }
    return clocks == 0 ? 1u : (uint8_t)clocks;
}

void lx_line_fault_begin(struct lx_line_fault *self, struct dg_faults *faults, uint8_t data_bits,
                         dg_ns clock)
{
    self->active = faults != NULL && faults->wire != 0;
    if (!self->active) {
        return;
    }
    struct lx_line_fault link = {.active = true};
    link.high = dg_fault_wire_active(faults, DG_WIRE_BREAK);
    link.high = dg_fault_wire_takes(faults, DG_WIRE_DROP) || link.high;
    if (dg_fault_wire_takes(faults, DG_WIRE_DELAY)) {
        link.delay = delay_of(clock);
    }
    if (dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
        link.flip = (uint8_t)(DATA_FIRST + dg_fault_pick(faults, data_bits));
    }
    *self = link;
}

void lx_line_fault_end(struct lx_line_fault *self, const struct dg_faults *faults)
{
    const bool cut = faults != NULL && dg_fault_wire_active(faults, DG_WIRE_BREAK);
    if (cut || self->active) {
        *self = (struct lx_line_fault){.active = cut, .high = cut};
    }
}

static bool flips(const struct lx_line_fault *self)
{
    return self->flip != 0 && self->bit == self->flip;
}

bool lx_line_fault_level(const struct lx_line_fault *self, bool raw)
{
    if (!self->active || self->high) {
        return raw || self->active;
    }
    if (self->delay == 0 || self->clocks < ACK_CLOCK) {
        return raw != flips(self);
    }
    const unsigned clock = self->clocks - self->delay;
    return self->clocks >= ACK_CLOCK + self->delay && self->held[clock % HELD];
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
        self->started = self->clocks > ACK_CLOCK && raw;
    }
    self->held[self->clocks % HELD] = raw != flips(self);
}
