/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The rig's time, which need not be real time.
 */
#ifndef DREHGEBER_LINUX_CLOCK_H
#define DREHGEBER_LINUX_CLOCK_H

#include <stdint.h>

#include "drehgeber/time.h"

/** The rig's clock: monotonic time, but where all wires are simulated it may be slowed down,
 * stopped, and stepped. */
struct lx_clock {
    dg_ns real;        /**< lx_now() when the rate was set last */
    dg_ns virtual_;    /**< the rig's time then */
    uint32_t permille; /**< 1000: as real time goes */
};

/** The rig's time now. */
dg_ns lx_clock_now(const struct lx_clock *self);
/** Real time at which the rig's time is `at`; DG_NEVER when it stands still. */
dg_ns lx_clock_real(const struct lx_clock *self, dg_ns at);

#endif
