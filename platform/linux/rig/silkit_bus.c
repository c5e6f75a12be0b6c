/* SPDX-License-Identifier: MIT */
/* A wire of a SIL Kit simulation is what its encoders speak. */
#include "biss_settings.h"
#include "bus.h"
#include "can_bus.h"
#include "hf_settings.h"
#include "modbus_settings.h"
#include "silkit.h"
#include "ssi_settings.h"

static const struct {
    const struct lx_stack *stack;
    lx_bus_make *make;
} kinds[] = {
    {&lx_can_stack, lx_can_bus_make_silkit},  {&lx_hf_stack, lx_line_bus_make_silkit},
    {&lx_biss_stack, lx_sim_bus_make_silkit}, {&lx_ssi_stack, lx_sim_bus_make_silkit},
    {&lx_ib_stack, lx_ring_bus_make_silkit},
};

struct lx_bus *lx_silkit_bus_make(const struct lx_bus_setup *setup, struct lx_error *error)
{
    const struct lx_stack *stack = lx_stack_of(setup->stations[0]->plan->model);
    size_t i = 0;
    if (lx_silkit_add(setup->silkit, setup->plan, setup->wire, error) != 0) {
        return NULL;
    }
    while (kinds[i].stack != stack) {
        i++;
    }
    return kinds[i].make(setup, error);
}
