/* SPDX-License-Identifier: MIT */
/*
 * The S36 BiSS behind the seam of all protocols.
 */
#include "biss_private.h"

static struct dg_biss_setup own(const struct dg_stack_setup *setup)
{
    return (struct dg_biss_setup){.model = setup->model, .world = setup->world, .nvm = setup->nvm};
}

static const struct dg_store_layout *layout(const void *model)
{
    return dg_biss_layout_of(model);
}

static bool senses_multiturn(const void *model)
{
    /* It monitors the sensor whatever its frame has room for. */
    (void)model;
    return true;
}

static int format(const struct dg_stack_setup *setup)
{
    return dg_store_format(layout(setup->model), setup->nvm, setup->model);
}

static int mount(const struct dg_stack_setup *setup, struct dg_store *store)
{
    return dg_biss_mount(store, setup->model, setup->nvm);
}

DG_STACK_FORWARD(dg_biss);

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct dg_biss *device = self;

    device->setup = setup != NULL ? own(setup) : (struct dg_biss_setup){0};
    device->store.layout = setup != NULL ? layout(setup->model) : NULL;
    device->store.nvm = device->setup.nvm;
}

static bool powered(const void *self)
{
    const struct dg_biss *device = self;

    return device->line.state != DG_BISS_OFF;
}

static dg_ns step(void *self, dg_ns now)
{
    return dg_biss_step(self, now);
}

static uint64_t position(const void *self, dg_ns now)
{
    const struct dg_biss *device = self;

    /* While it initialises a frame has position 0. */
    return powered(self) && now >= device->ready_at ? dg_biss_position(device, now) : 0;
}

const struct dg_stack dg_biss_stack = {
    .name = "biss",
    .medium = DG_MEDIUM_EDGES,
    .device_size = sizeof(struct dg_biss),
    .mount = mount,
    DG_STACK_OPERATIONS,
};

const struct dg_biss_model *dg_biss_model_of(const struct dg_device *device)
{
    return device != NULL && device->stack == &dg_biss_stack ? device->model : NULL;
}
