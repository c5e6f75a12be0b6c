/* SPDX-License-Identifier: MIT */
#include "bus.h"

void lx_bus_serve(struct lx_bus *self, dg_ns deadline, dg_ns now)
{
    if (now > dg_after(deadline, LX_BUS_LATE)) {
        self->late++;
    }
}

void *lx_bus_allocate(size_t size, const struct lx_bus_ops *ops, const struct lx_bus_setup *setup,
                      struct lx_error *error)
{
    struct lx_bus *self = lx_allocate(size, "a wire and its encoders", error);
    if (self != NULL) {
        *self = (struct lx_bus){.ops = ops, .setup = *setup};
    }
    return self;
}

int lx_bus_open(struct lx_bus *self, dg_ns now, struct lx_error *error)
{
    return self->ops->open(self, now, error) == 0
               ? 0
               : lx_plan_refuse_wire(self->setup.plan, self->setup.wire, error);
}
