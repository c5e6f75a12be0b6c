/* SPDX-License-Identifier: MIT */
/*
 * Encoders by name: whoever calls this links every model.
 */
#include "drehgeber/protocols.h"
#include "host_private.h"

#define ROW(prefix) &dg_##prefix##_side,
static const struct dg_bus_side *const sides[] = {DG_PROTOCOLS(ROW)};
#undef ROW

const struct dg_bus_side *dg_bus_side_of(const struct dg_device *model)
{
    for (size_t i = 0; model != NULL && i < DG_COUNT(sides); i++) {
        if (sides[i]->wire->stack == model->stack) {
            return sides[i];
        }
    }
    return NULL;
}

const struct dg_host_wire *dg_host_wire_of(const struct dg_device *model)
{
    const struct dg_bus_side *side = dg_bus_side_of(model);

    return side != NULL ? side->wire : NULL;
}

const char *dg_host_name(size_t index)
{
    return index < dg_device_count ? dg_devices[index]->name : NULL;
}

size_t dg_host_size_of(const char *name)
{
    const struct dg_device *model = dg_device_find(name);
    const struct dg_host_wire *wire = dg_host_wire_of(model);

    return wire != NULL ? dg_host_size(model, wire) : 0;
}

struct dg_host *dg_host_make(void *memory, size_t size, const char *name)
{
    const struct dg_device *model = dg_device_find(name);
    const struct dg_bus_side *side = dg_bus_side_of(model);
    struct dg_host *self = side != NULL ? dg_host_init(memory, size, model, side->wire) : NULL;

    if (self != NULL) {
        dg_host_take_side(self, side);
    }
    return self;
}
