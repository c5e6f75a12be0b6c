/* SPDX-License-Identifier: MIT */
/*
 * Encoders by name: whoever calls this links every model.
 */
#include "host_private.h"

static const struct dg_host_wire *const wires[] = {
    &dg_hf_wire, &dg_biss_wire, &dg_ssi_wire, &dg_cia406_wire, &dg_ib_wire,
};

const struct dg_host_wire *dg_host_wire_of(const struct dg_device *model)
{
    for (size_t i = 0; model != NULL && i < DG_COUNT(wires); i++) {
        if (wires[i]->stack == model->stack) {
            return wires[i];
        }
    }
    return NULL;
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
    const struct dg_host_wire *wire = dg_host_wire_of(model);

    return wire != NULL ? dg_host_init(memory, size, model, wire) : NULL;
}
