/* SPDX-License-Identifier: MIT */
/*
 * Moments in picoseconds, as simulators count: apart, so that who has others does not link this.
 */
#include "host_private.h"

#define PS_PER_NS 1000u

uint64_t dg_host_step_ps(struct dg_host *self, uint64_t now)
{
    const uint64_t next = dg_host_step(self, now / PS_PER_NS);

    return next > UINT64_MAX / PS_PER_NS ? DG_HOST_NEVER : next * PS_PER_NS;
}

int dg_host_clock_ps(struct dg_host *self, uint64_t now, bool level)
{
    return dg_host_clock(self, now / PS_PER_NS, level);
}
