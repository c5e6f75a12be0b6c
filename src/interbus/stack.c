/* SPDX-License-Identifier: MIT */
/*
 * The OCD INTERBUS behind the seam of all protocols.
 */
#include "interbus_private.h"

static struct dg_ib_setup own(const struct dg_stack_setup *setup)
{
    return (struct dg_ib_setup){.model = setup->model, .world = setup->world, .nvm = setup->nvm};
}

static const struct dg_store_layout *layout(const void *model)
{
    return dg_ib_layout_of(model);
}

static bool senses_multiturn(const void *model)
{
    const struct dg_ib_model *figures = model;

    return figures->turns > 1;
}

static int format(const struct dg_stack_setup *setup)
{
    return dg_ib_format(setup->model, setup->nvm);
}

static int mount(const struct dg_stack_setup *setup, struct dg_store *store)
{
    return dg_ib_mount(store, setup->model, setup->nvm);
}

DG_STACK_FORWARD(dg_ib);

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct dg_ib *device = self;

    device->setup = setup != NULL ? own(setup) : (struct dg_ib_setup){0};
    device->store.layout = setup != NULL && device->mounted ? layout(setup->model) : NULL;
    device->store.nvm = device->setup.nvm;
}

static bool powered(const void *self)
{
    const struct dg_ib *device = self;

    return device->powered;
}

static dg_ns step(void *self, dg_ns now)
{
    /* It does everything in the cycles of its ring. */
    (void)self;
    (void)now;
    return DG_NEVER;
}

static uint64_t position(const void *self, dg_ns now)
{
    return powered(self) ? dg_ib_position(self, now) : 0;
}

const struct dg_stack dg_ib_stack = {
    .name = "interbus",
    .medium = DG_MEDIUM_WORDS,
    .device_size = sizeof(struct dg_ib),
    .mount = mount,
    DG_STACK_OPERATIONS,
};

const struct dg_ib_model *dg_ib_model_of(const struct dg_device *device)
{
    return device != NULL && device->stack == &dg_ib_stack ? device->model : NULL;
}
