/* SPDX-License-Identifier: MIT */
/* A wire of a SIL Kit simulation is what its encoders speak. */
#include "bus.h"
#include "can.h"
#include "serial.h"
#include "silkit.h"

static const struct lx_wire doors[] = {
    [DG_MEDIUM_CHARACTERS] = {.make = lx_line_bus_make, .open_port = lx_silkit_serial_open},
    [DG_MEDIUM_FRAMES] = {.make = lx_can_bus_make, .open_can = lx_silkit_can_open},
    [DG_MEDIUM_EDGES] = {.make = lx_sim_bus_make, .driven = true},
    [DG_MEDIUM_WORDS] = {.make = lx_ring_bus_make, .driven = true},
};
_Static_assert(DG_COUNT(doors) == DG_MEDIUM_COUNT, "a door for each medium");

static const struct lx_wire packed_can = {.make = lx_can_bus_make, .open_can = lx_silkit_pack_open};

struct lx_bus *lx_silkit_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                  struct lx_error *error)
{
    const enum dg_medium medium = setup->stations[0]->plan->model->stack->medium;
    const bool packed = to->line.simulation.frames == DG_PLAN_FRAMES_PACKED;
    if (packed && medium != DG_MEDIUM_FRAMES) {
        (void)lx_refuse(error, "leave it out", "frames = packed: only a CAN bus has frames");
        return NULL;
    }
    struct lx_bus_setup there = *setup;
    there.door = packed ? &packed_can : &doors[medium];
    const bool added = lx_silkit_add(setup->silkit, setup->plan, setup->wire, error) == 0;
    return added ? there.door->make(&there, to, error) : NULL;
}
