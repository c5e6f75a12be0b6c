/* SPDX-License-Identifier: MIT */
/* An encoder of a CAN bus: what the plan says about it, its EEPROM, its power. */
#define _GNU_SOURCE
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "can_bus.h"
#include "drehgeber/cia406.h"
#include "trace_format.h"

/* --- the plan --- */

static void defaults(void *settings, const struct dg_device *device)
{
    dg_cia406_settings_init(settings, dg_cia406_model_of(device));
}

static uint32_t without(const struct dg_device *device)
{
    return dg_cia406_without(dg_cia406_model_of(device));
}

static const char title[] = "CAN";
static const struct lx_trace_format *const formats[] = {&lx_trace_log, &lx_trace_pcapng,
                                                        &lx_trace_pcap, NULL};
static const struct lx_trace_kind trace = {title, formats, false};

const struct lx_stack lx_can_stack = {
    .core = &dg_cia406_stack,
    .title = title,
    .trace = &trace,
    .words = &dg_cia406_words,
    .wire = "slcan",
    .keys = &dg_cia406_keys,
    .settings_size = sizeof(struct dg_cia406_settings),
    .defaults = defaults,
    .without = without,
};

/* Node-ID and serial number are what the plan says of this encoder; its other keys are read into
   the encoder's settings. */
static int take_settings(struct lx_can_node *self, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus->bus.setup;
    struct lx_station *station = self->station;
    const struct dg_plan_encoder *plan = station->plan;
    const struct lx_stack *stack = lx_stack_of(plan->model);
    void *settings = dg_host_line_of(self->host)->settings;
    if (lx_stack_settings(setup->plan, setup->wire, plan, settings, &station->world, error) != 0) {
        return -1;
    }
    const struct dg_stack_setup device = dg_host_setup(self->host);
    const uint32_t place = plan->serial == NULL ? (uint32_t)station->place : 0;
    char text[16];
    station->control.serial = device.serial + place;
    (void)snprintf(text, sizeof text, "%lu", (unsigned long)station->control.serial);
    (void)dg_host_set(self->host, lx_stack_serial(stack)->name, text);
    self->id = plan->address == DG_PLAN_AS_DELIVERED ? stack->core->address_delivered
                                                     : (uint32_t)plan->address;
    (void)snprintf(text, sizeof text, "%lu", (unsigned long)self->id);
    (void)dg_host_set(self->host, stack->core->address_key, text);
    *dg_host_world(self->host) = station->world;
    station->control.world = dg_host_world(self->host);
    return 0;
}

static int make_host(struct lx_can_node *self, struct lx_error *error)
{
    const struct dg_device *model = self->station->plan->model;
    const struct dg_bus_side *side = dg_bus_side_of(model);
    const size_t size = dg_host_size_with_port(model, side);
    void *memory = aligned_alloc(DG_HOST_ALIGN, size);
    if (memory == NULL) {
        return lx_fail(error, "no memory for an encoder");
    }
    self->host = dg_host_init_on_bus(memory, size, model, side);
    self->ask = side->controller;
    self->device = dg_host_line_of(self->host)->device;
    return dg_bus_attach(self->bus->wire, self->host, &self->station->control) >= 0
               ? 0
               : lx_fail(error, "no place for this encoder on the bus");
}

int lx_can_node_make(struct lx_can_bus *bus, size_t place, struct lx_error *error)
{
    struct lx_can_node *self = &bus->node[place];
    *self = (struct lx_can_node){.bus = bus, .station = bus->bus.setup.stations[place]};
    return make_host(self, error) == 0 ? take_settings(self, error) : -1;
}

/* --- EEPROM and power --- */

static int open_memory(struct lx_can_node *self, void (*settled)(void *ctx, dg_ns now),
                       struct lx_error *error)
{
    const struct lx_bus_setup *bus = &self->bus->bus.setup;
    const struct dg_plan_encoder *plan = self->station->plan;
    const struct lx_image_setup image = {
        .path = plan->nvm,
        .answer = "the encoder answers abort 06060000h",
        .parts = &self->memory,
        .count = 1,
        .say = bus->say,
        .writer = bus->writer,
        .settled = settled,
        .ctx = self,
    };
    self->memory = (struct lx_image_part){
        .stack = plan->model->stack,
        .device = dg_host_setup(self->host),
        .serial_given = plan->serial != NULL,
    };
    if (lx_image_open(&self->image, &image, error) != 0) {
        return -1;
    }
    const int result = lx_image_start(&self->image, error);
    self->station->control.nvm = self->memory.device.nvm;
    self->station->queue = lx_image_queue(&self->image);
    return result;
}

uint32_t lx_can_node_id(const struct lx_can_node *self)
{
    return self->ask->address(self->device);
}

uint64_t lx_can_node_kbaud(const struct lx_can_node *self)
{
    return self->ask->bit_rate(self->device) / 1000u;
}

/* A file may know a node-ID that was set over the bus. */
static void tell_node_id(const struct lx_can_node *self)
{
    const uint32_t id = lx_can_node_id(self);
    if (id != self->id) {
        lx_note(self->bus->bus.setup.say, "%s: its node-ID is %u, not %u", self->station->plan->nvm,
                (unsigned)id, (unsigned)self->id);
    }
}

static bool was_shared(const struct lx_can_node *self, uint16_t id)
{
    size_t i = 0;
    while (i < DG_HOST_SHARED && self->shared[i] != id) {
        i++;
    }
    return i < DG_HOST_SHARED;
}

void lx_can_tell_shared(struct lx_can_node *self)
{
    const uint32_t version = self->ask->version(self->device);
    uint16_t ids[DG_HOST_SHARED] = {0};
    if (self->version == version) {
        return;
    }
    self->version = version;
    const uint8_t count = self->ask->shared(self->device, ids);
    for (uint8_t i = 0; i < count; i++) {
        if (!was_shared(self, ids[i])) {
            lx_note(self->bus->bus.setup.say,
                    "%s/%u: two services of this node have the CAN-ID %03Xh, both send",
                    self->bus->can->address, (unsigned)lx_can_node_id(self), ids[i]);
        }
    }
    memcpy(self->shared, ids, sizeof ids);
}

static int power_on(struct lx_can_node *self, dg_ns now, struct lx_error *error)
{
    if (dg_host_memory_port(self->host, &self->station->control.nvm) != DG_HOST_OK) {
        return lx_fail(error, "the encoder was on already");
    }
    dg_host_memory_known(self->host);
    if (dg_host_power(self->host, now, true) != DG_HOST_OK) {
        return lx_fail(error, "the encoder does not start: not its EEPROM");
    }
    self->station->control.device = dg_host_line_of(self->host)->device;
    return 0;
}

int lx_can_node_open(struct lx_can_node *self, void (*settled)(void *ctx, dg_ns now), dg_ns now,
                     struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus->bus.setup;
    if (open_memory(self, settled, error) != 0 || power_on(self, now, error) != 0) {
        return lx_plan_refuse_key(setup->plan, "nvm", self->station->plan->nvm_line, error);
    }
    tell_node_id(self);
    return 0;
}

void lx_can_node_close(struct lx_can_node *self)
{
    if (self->station != NULL && self->station->control.device != NULL) {
        self->station->plan->model->stack->power_off(self->station->control.device);
        self->station->control.device = NULL; /* it goes with its handle */
    }
    lx_image_close(&self->image);
    free(self->host);
}
