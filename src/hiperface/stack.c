/* SPDX-License-Identifier: MIT */
/*
 * The S36 RS485 behind the seam of all protocols.
 */
#include "hiperface_private.h"

static struct dg_hf_setup own(const struct dg_stack_setup *setup)
{
    return (struct dg_hf_setup){.model = setup->model,
                                .world = setup->world,
                                .nvm = setup->nvm,
                                .ops = setup->port,
                                .ctx = setup->ctx};
}

static const struct dg_store_layout *layout(const void *model)
{
    return dg_hf_layout_of(model);
}

static bool senses_multiturn(const void *model)
{
    const struct dg_hf_model *figures = model;

    return figures->turns > 1;
}

static int mount(const struct dg_stack_setup *setup, struct dg_store *store)
{
    return dg_hf_mount(store, setup->model, setup->nvm);
}

static int format(const struct dg_stack_setup *setup)
{
    const uint8_t uart[] = {DG_HF_UART_DEFAULT, (uint8_t)setup->address};
    struct dg_store store;

    if (setup->address == 0) {
        return dg_hf_format(setup->model, setup->nvm);
    }
    if (setup->address < DG_HF_ADDRESS_DEFAULT || setup->address > DG_HF_ADDRESS_LAST) {
        return DG_ERR_ARGUMENT;
    }
    int result = dg_hf_format(setup->model, setup->nvm);
    if (result == DG_OK) {
        result = mount(setup, &store);
    }
    return result == DG_OK ? dg_store_put(&store, DG_HF_REGION_UART, 0, uart, sizeof uart) : result;
}

static const char *differs(const struct dg_stack_setup *setup, struct dg_store *store)
{
    return dg_hf_differs(setup->model, store);
}

DG_STACK_FORWARD(dg_hf);

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct dg_hf *device = self;

    device->setup = setup != NULL ? own(setup) : (struct dg_hf_setup){0};
    device->store.layout = setup != NULL ? layout(setup->model) : NULL;
    device->store.nvm = device->setup.nvm;
}

static bool powered(const void *self)
{
    const struct dg_hf *device = self;

    return device->line != DG_HF_OFF;
}

static dg_ns step(void *self, dg_ns now)
{
    return dg_hf_step(self, now);
}

static uint64_t position(const void *self, dg_ns now)
{
    return powered(self) ? dg_hf_position(self, now) : 0;
}

const struct dg_stack dg_hf_stack = {
    .name = "hiperface",
    .medium = DG_MEDIUM_CHARACTERS,
    .address_key = "address",
    .address_what = "an RS485 address",
    .address_delivered = DG_HF_ADDRESS_DEFAULT,
    .address_hex = true,
    .device_size = sizeof(struct dg_hf),
    .mount = mount,
    .differs = differs,
    .serial = dg_hf_serial,
    DG_STACK_OPERATIONS,
};

const struct dg_hf_model *dg_hf_model_of(const struct dg_device *device)
{
    return device != NULL && device->stack == &dg_hf_stack ? device->model : NULL;
}
