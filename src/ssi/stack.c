/* SPDX-License-Identifier: MIT */
/*
 * SSI behind the seam of all protocols.
 */
#include "ssi_private.h"

_Static_assert(_Alignof(struct dg_ssi) <= _Alignof(max_align_t), "as stack.h promises");

static struct dg_ssi_setup own(const struct dg_stack_setup *setup)
{
    return (struct dg_ssi_setup){.model = setup->model, .world = setup->world};
}

DG_STACK_WITHOUT_MEMORY; /* no model has an EEPROM */

static bool senses_multiturn(const void *model)
{
    const struct dg_ssi_model *figures = model;

    return figures->multiturn_bits != 0;
}

static int format(const struct dg_stack_setup *setup)
{
    return dg_ssi_model_ok(setup->model) ? DG_OK : DG_ERR_ARGUMENT;
}

static int init(void *self, const struct dg_stack_setup *setup)
{
    const struct dg_ssi_setup mine = own(setup);

    return dg_ssi_init(self, &mine);
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct dg_ssi *device = self;

    device->setup = setup != NULL ? own(setup) : (struct dg_ssi_setup){0};
}

static int power_on(void *self, dg_ns now)
{
    dg_ssi_power_on(self, now);
    return DG_OK;
}

static void power_off(void *self)
{
    dg_ssi_power_off(self);
}

static bool powered(const void *self)
{
    const struct dg_ssi *device = self;

    return device->state != DG_SSI_OFF;
}

static dg_ns step(void *self, dg_ns now)
{
    return dg_ssi_step(self, now);
}

static const void *model(const void *self)
{
    const struct dg_ssi *device = self;

    return device->setup.model;
}

static uint64_t position(const void *self, dg_ns now)
{
    const struct dg_ssi *device = self;
    const bool starting = device->state == DG_SSI_START && now < device->deadline;

    return powered(self) && !starting ? dg_ssi_position(device, now) : 0;
}

const struct dg_stack dg_ssi_stack = {
    .name = "ssi",
    .medium = DG_MEDIUM_EDGES,
    .device_size = sizeof(struct dg_ssi),
    .mount = mount,
    DG_STACK_OPERATIONS,
};

const struct dg_ssi_model *dg_ssi_model_of(const struct dg_device *device)
{
    return device != NULL && device->stack == &dg_ssi_stack ? device->model : NULL;
}
