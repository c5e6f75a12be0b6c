/* SPDX-License-Identifier: MIT */
#include "can_load.h"

/* In milliseconds: a window may have been open for years, and still fits. */
static uint32_t load(const struct lx_can_load *self, dg_ns now, uint64_t bits, uint32_t bit_rate)
{
    const uint64_t sent = bits > self->bits ? bits - self->bits : 0;
    const uint64_t room = dg_elapsed(now, self->since) / DG_MS(1) * bit_rate / 1000u;
    const uint64_t permille = room == 0 ? 0 : sent * 1000u / room;
    return permille > UINT32_MAX ? UINT32_MAX : (uint32_t)permille;
}

void lx_can_load_begin(struct lx_can_load *self, dg_ns now, uint64_t bits)
{
    *self = (struct lx_can_load){.since = now, .bits = bits};
}

bool lx_can_load_take(struct lx_can_load *self, dg_ns now, uint64_t bits, uint32_t bit_rate)
{
    const bool before = self->overloaded;
    self->permille = load(self, now, bits, bit_rate);
    self->since = now;
    self->bits = bits;
    if (self->permille > LX_CAN_OVERLOAD_PERMILLE) {
        self->overloaded = true;
    } else if (self->permille <= LX_CAN_RELIEF_PERMILLE) {
        self->overloaded = false;
    }
    return self->overloaded && !before;
}

uint32_t lx_can_load_permille(const struct lx_can_load *self, dg_ns now, uint64_t bits,
                              uint32_t bit_rate)
{
    return lx_can_load_due(self, now) ? load(self, now, bits, bit_rate) : self->permille;
}
