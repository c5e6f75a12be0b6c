/* SPDX-License-Identifier: MIT */
#include "station.h"

#include "bus.h"

size_t lx_station_index(const struct lx_station *self, const struct lx_bus_setup *bus)
{
    return (size_t)(self->plan - bus->plan->encoders);
}

static int open_memory(struct lx_station *self, const struct lx_image_setup *image,
                       struct lx_error *error)
{
    self->memory = (struct lx_image_part){
        .stack = self->plan->model->stack,
        .device = dg_host_setup(self->host),
        .serial_given = self->plan->serial != NULL,
    };
    self->memory.device.serial = self->control->serial;
    if (lx_image_open(&self->image, image, error) != 0 ||
        lx_image_start(&self->image, error) != 0) {
        return -1;
    }
    self->queue = lx_image_queue(&self->image);
    (void)dg_host_memory_port(self->host, &self->memory.device.nvm);
    dg_host_memory_known(self->host);
    return 0;
}

int lx_station_open(struct lx_station *self, const struct lx_bus_setup *bus,
                    void (*settled)(void *ctx, dg_ns now), void *ctx, dg_ns now,
                    struct lx_error *error)
{
    const struct lx_image_setup image = {
        .path = self->plan->nvm,
        .answer = lx_stack_of(self->plan->model)->spoiled,
        .parts = &self->memory,
        .count = 1,
        .say = bus->say,
        .writer = bus->writer,
        .settled = settled,
        .ctx = ctx,
    };
    struct dg_plan_error wrong;
    if (dg_host_memory_size(self->host) != 0 && open_memory(self, &image, error) != 0) {
        return lx_plan_refuse_key(bus->plan, "nvm", self->plan->nvm_line, error);
    }
    return dg_engine_power_encoder(bus->engine, lx_station_index(self, bus), now, &wrong) == 0
               ? 0
               : lx_fail(error, "%s", wrong.what);
}

void lx_station_close(struct lx_station *self)
{
    if (self->host != NULL && dg_host_powered(self->host)) {
        self->plan->model->stack->power_off(self->control->device);
    }
    lx_image_close(&self->image);
}
