/* SPDX-License-Identifier: MIT */
/*
 *   now   = virtual_ + (lx_now() - real) * permille / 1000      rounded down
 *   real' = real + (at - virtual_) * 1000 / permille            rounded up: never early
 */
#include "clock.h"

#include "drehgeber/angle.h"
#include "timer.h"

#define ONE 1000u

dg_ns lx_clock_now(const struct lx_clock *self)
{
    const dg_ns elapsed = dg_elapsed(lx_now(), self->real);
    return dg_after(self->virtual_, dg_muldiv(elapsed, self->permille, ONE));
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
    const dg_ns down = dg_muldiv(span, ONE, self->permille);
    const bool exact = span % self->permille * ONE % self->permille == 0;
    return dg_after(self->real, dg_after(down, exact ? 0 : 1));
}
