/* SPDX-License-Identifier: MIT */
/* A wire of a SIL Kit simulation is what its encoders speak. */
#include "bus.h"
#include "silkit.h"

static lx_bus_make *const makers[] = {
    [DG_MEDIUM_CHARACTERS] = lx_line_bus_make_silkit,
    [DG_MEDIUM_FRAMES] = lx_can_bus_make_silkit,
    [DG_MEDIUM_EDGES] = lx_sim_bus_make_silkit,
    [DG_MEDIUM_WORDS] = lx_ring_bus_make_silkit,
};
_Static_assert(DG_COUNT(makers) == DG_MEDIUM_COUNT, "a maker for each medium");

struct lx_bus *lx_silkit_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                  struct lx_error *error)
{
    const enum dg_medium medium = setup->stations[0]->plan->model->stack->medium;
    const bool packed = to->line.simulation.frames == DG_PLAN_FRAMES_PACKED;
    if (packed && medium != DG_MEDIUM_FRAMES) {
        (void)lx_refuse(error, "leave it out", "frames = packed: only a CAN bus has frames");
        return NULL;
    }
    const bool added = lx_silkit_add(setup->silkit, setup->plan, setup->wire, error) == 0;
    return added ? makers[medium](setup, to, error) : NULL;
}
