/* SPDX-License-Identifier: MIT */
/* A wire of a SIL Kit simulation is what its encoders speak. */
#include "can_bus.h"
#include "silkit.h"

struct lx_bus *lx_silkit_bus_make(const struct lx_bus_setup *setup, struct lx_error *error)
{
    if (lx_silkit_add(setup->silkit, setup->plan, setup->wire, error) != 0) {
        return NULL;
    }
    return lx_can_bus_make(setup, lx_silkit_can_open, error);
}
