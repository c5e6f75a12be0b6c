/* SPDX-License-Identifier: MIT */
/*
 * A shaft of the host's: apart, so that who has none does not link its motions.
 */
#include "drehgeber/shaft.h"

#include "host_private.h"

void dg_host_shaft_of(struct dg_host *self, struct dg_shaft *shaft)
{
    if (shaft == NULL) {
        dg_host_sit(self, self, dg_host_own_angle);
    } else {
        dg_host_sit(self, shaft, dg_shaft_angle);
    }
}
