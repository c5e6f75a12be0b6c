/* SPDX-License-Identifier: MIT */
#include "station.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus.h"
#include "drehgeber/figure.h"

static const struct lx_stack *stack_of(const struct lx_station *self)
{
    return lx_stack_of(self->plan->model);
}

/* --- from the plan --- */

/* @return false without memory */
static bool make_host(struct lx_station *self)
{
    const struct dg_device *model = self->plan->model;
    const struct dg_bus_side *side = dg_bus_side_of(model);
    const size_t size = dg_host_size_with_port(model, side);
    void *memory = aligned_alloc(DG_HOST_ALIGN, size);
    self->host = memory == NULL ? NULL : dg_host_init_on_bus(memory, size, model, side);
    if (self->host == NULL) {
        free(memory);
    }
    return self->host != NULL;
}

/* Of a new EEPROM. */
static void set_address(const struct lx_station *self)
{
    const struct dg_key *row = dg_plan_address_row(self->plan->model);
    if (row != NULL && self->plan->address != DG_PLAN_AS_DELIVERED) {
        char text[16];
        (void)snprintf(text, sizeof text, "%d", self->plan->address);
        (void)dg_host_set(self->host, row->name, text);
    }
}

int lx_station_make(struct lx_station *self, const struct lx_bus_setup *bus, void *settings,
                    struct lx_error *error)
{
    const struct dg_plan_encoder *plan = self->plan;
    if (!make_host(self)) {
        return lx_fail(error, "no memory for an encoder");
    }
    void *own = dg_host_line_of(self->host)->settings;
    if (lx_stack_settings(bus->plan, bus->wire, plan, settings == NULL ? own : settings,
                          &self->world, error) != 0) {
        return -1;
    }
    if (settings != NULL) {
        memcpy(own, settings, dg_host_wire_at(self->host)->settings_size);
    }
    set_address(self);
    if (plan->nvm != NULL && dg_host_memory_size(self->host) == 0) {
        (void)lx_refuse(error, "leave it out", "%s has no EEPROM", plan->model->name);
        return lx_plan_refuse_key(bus->plan, "nvm", plan->nvm_line, error);
    }
    self->control.world = dg_host_world(self->host);
    *self->control.world = self->world;
    return 0;
}

/* --- EEPROM and power --- */

/* What the plan or the model says; 0: neither does, or there is none. */
static uint32_t serial_of(const struct lx_station *self)
{
    const struct dg_key *row = lx_stack_serial(stack_of(self));
    char text[32];
    uint64_t serial = 0;
    return row != NULL &&
                   dg_key_get(row, dg_host_line_of(self->host)->settings, text, sizeof text) > 0 &&
                   dg_unsigned_parse(text, &serial)
               ? (uint32_t)serial
               : 0;
}

static int open_memory(struct lx_station *self, const struct lx_image_setup *image,
                       struct lx_error *error)
{
    self->memory = (struct lx_image_part){
        .stack = self->plan->model->stack,
        .device = dg_host_setup(self->host),
        .serial_given = self->plan->serial != NULL,
    };
    self->memory.device.serial = serial_of(self);
    if (lx_image_open(&self->image, image, error) != 0 ||
        lx_image_start(&self->image, error) != 0) {
        return -1;
    }
    self->control.nvm = self->memory.device.nvm;
    self->queue = lx_image_queue(&self->image);
    (void)dg_host_memory_port(self->host, &self->control.nvm);
    dg_host_memory_known(self->host);
    return 0;
}

int lx_station_open(struct lx_station *self, const struct lx_bus_setup *bus,
                    void (*settled)(void *ctx, dg_ns now), void *ctx, dg_ns now,
                    struct lx_error *error)
{
    const struct lx_image_setup image = {
        .path = self->plan->nvm,
        .answer = stack_of(self)->spoiled,
        .parts = &self->memory,
        .count = 1,
        .say = bus->say,
        .writer = bus->writer,
        .settled = settled,
        .ctx = ctx,
    };
    if (dg_host_memory_size(self->host) != 0 && open_memory(self, &image, error) != 0) {
        return lx_plan_refuse_key(bus->plan, "nvm", self->plan->nvm_line, error);
    }
    const int result = dg_host_power(self->host, now, true);
    if (result != DG_HOST_OK) {
        return result == DG_HOST_ERR_ARGUMENT
                   ? lx_fail(error, "these figures make no encoder")
                   : lx_fail(error, "the encoder does not start: not its EEPROM");
    }
    self->control.device = dg_host_line_of(self->host)->device;
    return 0;
}

void lx_station_close(struct lx_station *self)
{
    if (self->host == NULL) {
        return;
    }
    if (dg_host_powered(self->host)) {
        self->plan->model->stack->power_off(self->control.device);
    }
    self->control.device = NULL; /* it goes with its handle */
    lx_image_close(&self->image);
    free(self->host);
    self->host = NULL;
}
