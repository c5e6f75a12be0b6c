/* SPDX-License-Identifier: MIT */
/*
 * The F36x8 behind the seam of all protocols.
 */
#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"

_Static_assert(_Alignof(struct dg_cia406_device) <= _Alignof(max_align_t), "as stack.h promises");

static struct dg_co_setup co_setup_of(struct dg_cia406_device *self,
                                      const struct dg_stack_setup *setup)
{
    const struct dg_cia406_model *model = setup->model;

    return (struct dg_co_setup){.device = model->device,
                                .world = setup->world,
                                .nvm = setup->nvm,
                                .ops = setup->port,
                                .ctx = setup->ctx,
                                .application = &self->encoder};
}

static const struct dg_store_layout *layout(const void *model)
{
    const struct dg_cia406_model *figures = model;

    return figures->device->layout;
}

static bool senses_multiturn(const void *model)
{
    const struct dg_cia406_model *figures = model;

    return figures->turns > 1;
}

static int format(const struct dg_stack_setup *setup)
{
    const struct dg_cia406_model *model = setup->model;

    int result = setup->address <= 127 ? dg_co_format(model->device, setup->nvm, setup->serial)
                                       : DG_ERR_ARGUMENT;

    return result == DG_OK && setup->address != 0
               ? dg_co_burn_node_id(model->device, setup->nvm, setup->address)
               : result;
}

static int mount(const struct dg_stack_setup *setup, struct dg_store *store)
{
    const struct dg_cia406_model *model = setup->model;

    return dg_co_mount(store, model->device, setup->nvm);
}

static int64_t serial(struct dg_store *store)
{
    uint8_t bytes[4];
    const bool readable =
        !dg_store_damaged(store, DG_CO_REGION_SERIAL) &&
        dg_store_read(store, DG_CO_REGION_SERIAL, 0, bytes, sizeof bytes) == DG_OK;

    return readable ? (int64_t)dg_load_le32(bytes) : -1;
}

static int init(void *self, const struct dg_stack_setup *setup)
{
    struct dg_cia406_device *device = self;
    const int result =
        setup->model != NULL ? dg_cia406_init(&device->encoder, setup->model) : DG_ERR_ARGUMENT;

    if (result != DG_OK) {
        return result;
    }
    const struct dg_co_setup mine = co_setup_of(device, setup);
    return dg_co_init(&device->node, &mine);
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct dg_cia406_device *device = self;

    device->encoder.model = setup != NULL ? setup->model : NULL;
    if (setup != NULL) {
        const struct dg_co_setup mine = co_setup_of(device, setup);
        dg_co_attach(&device->node, &mine);
    } else {
        dg_co_attach(&device->node, NULL);
    }
}

static int power_on(void *self, dg_ns now)
{
    struct dg_cia406_device *device = self;

    return dg_co_power_on(&device->node, now);
}

static void power_off(void *self)
{
    struct dg_cia406_device *device = self;

    dg_co_power_off(&device->node);
}

static bool powered(const void *self)
{
    const struct dg_cia406_device *device = self;

    return device->node.state != DG_CO_OFF;
}

static dg_ns step(void *self, dg_ns now)
{
    struct dg_cia406_device *device = self;

    return dg_co_step(&device->node, now);
}

static const void *model(const void *self)
{
    const struct dg_cia406_device *device = self;

    return device->encoder.model;
}

static uint64_t position(const void *self, dg_ns now)
{
    const struct dg_cia406_device *device = self;

    return powered(self) ? dg_cia406_position(&device->node, now) : 0;
}

const struct dg_stack dg_cia406_stack = {
    .name = "canopen",
    .medium = DG_MEDIUM_FRAMES,
    .address_key = "node",
    .address_what = "a node-ID",
    .address_delivered = DG_CIA406_NODE_DEFAULT,
    .device_size = sizeof(struct dg_cia406_device),
    .mount = mount,
    .serial = serial,
    DG_STACK_OPERATIONS,
};

const struct dg_cia406_model *dg_cia406_model_of(const struct dg_device *device)
{
    return device != NULL && device->stack == &dg_cia406_stack ? device->model : NULL;
}
