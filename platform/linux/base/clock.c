/* SPDX-License-Identifier: MIT */
/*
 *   now   = virtual_ + (lx_now() - real) * permille / 1000      rounded down
 *   real' = real + (at - virtual_) * 1000 / permille            rounded up: never early
 */
#include "clock.h"

#include "timer.h"

#define ONE 1000u

/* span * times / parts, rounded down; `times` and `parts` have 32 bits, so that only a result
   beyond 64 bits overflows: DG_NEVER then. The products of `rest` fit: it is below 2^32. */
static dg_ns scale_span(dg_ns span, uint32_t times, uint32_t parts)
{
    const dg_ns whole = span / parts;
    const dg_ns rest = span % parts;
    if (times != 0 && whole > DG_NEVER / times) {
        return DG_NEVER;
    }
    return dg_after(whole * times, rest * times / parts);
}

dg_ns lx_clock_now(const struct lx_clock *self)
{
    const dg_ns elapsed = dg_elapsed(lx_now(), self->real);
    return dg_after(self->virtual_, scale_span(elapsed, self->permille, ONE));
}

dg_ns lx_clock_real(const struct lx_clock *self, dg_ns at)
{
    const dg_ns span = dg_elapsed(at, self->virtual_);
    if (span == 0) {
        return self->real;
    }
    if (at == DG_NEVER || self->permille == 0) {
        return DG_NEVER;
    }
    const dg_ns down = scale_span(span, ONE, self->permille);
    const bool exact = span % self->permille * ONE % self->permille == 0;
    return dg_after(self->real, dg_after(down, exact ? 0 : 1));
}
