/* SPDX-License-Identifier: MIT */
/* How much of a bus of frames is used. */
#include "drehgeber/bus_frames.h"

/* In milliseconds: a window may have been open for years, and still fits. */
static uint32_t measure_load(const struct dg_bus_load *self, dg_ns now, uint64_t bits,
                             uint32_t bit_rate)
{
    const uint64_t sent = bits > self->bits ? bits - self->bits : 0;
    const uint64_t room = dg_elapsed(now, self->since) / DG_MS(1) * bit_rate / 1000u;
    const uint64_t permille = room == 0 ? 0 : sent * 1000u / room;
    return permille > UINT32_MAX ? UINT32_MAX : (uint32_t)permille;
}

void dg_bus_load_begin(struct dg_bus_load *self, dg_ns now, uint64_t bits)
{
    *self = (struct dg_bus_load){.since = now, .bits = bits};
}

bool dg_bus_load_close(struct dg_bus_load *self, dg_ns now, uint64_t bits, uint32_t bit_rate)
{
    const bool before = self->overloaded;
    self->permille = measure_load(self, now, bits, bit_rate);
    self->since = now;
    self->bits = bits;
    if (self->permille > DG_BUS_OVERLOAD_PERMILLE) {
        self->overloaded = true;
    } else if (self->permille <= DG_BUS_RELIEF_PERMILLE) {
        self->overloaded = false;
    }
    return self->overloaded && !before;
}

uint32_t dg_bus_load_permille(const struct dg_bus_load *self, dg_ns now, uint64_t bits,
                              uint32_t bit_rate)
{
    return dg_bus_load_due(self, now) ? measure_load(self, now, bits, bit_rate) : self->permille;
}
