/* SPDX-License-Identifier: MIT */
/* An encoder of a CAN bus: what the plan says about it, its EEPROM, its power. */
#define _GNU_SOURCE
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "can_bus.h"
#include "drehgeber/bits.h"
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
    .address = {"a node-ID", DG_CIA406_NODE_DEFAULT, false},
    .keys = &dg_cia406_keys,
    .settings_size = sizeof(struct dg_cia406_settings),
    .defaults = defaults,
    .without = without,
};

static int take_settings(struct lx_can_node *self, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus->bus.setup;
    struct lx_station *station = self->station;
    const struct lx_plan_encoder *plan = station->plan;
    const int delivered = lx_can_stack.address.delivered;
    struct dg_cia406_settings settings;
    if (lx_stack_settings(setup->plan, setup->wire, plan, &settings, &station->world, error) != 0) {
        return -1;
    }
    const uint32_t place = plan->serial == NULL ? (uint32_t)station->place : 0;
    station->control.serial = settings.serial + place;
    self->id = (uint8_t)(plan->address == LX_PLAN_AS_DELIVERED ? delivered : plan->address);
    dg_cia406_settings_apply(&settings);
    self->model = settings.model;
    return 0;
}

int lx_can_node_make(struct lx_can_bus *bus, size_t place, struct lx_error *error)
{
    struct lx_can_node *self = &bus->node[place];
    struct lx_station *station = bus->bus.setup.stations[place];
    const struct lx_plan_encoder *plan = station->plan;
    *self = (struct lx_can_node){
        .bus = bus,
        .station = station,
        .model = *dg_cia406_model_of(plan->model),
        .index = LX_CAN_DEAF,
    };
    return take_settings(self, error);
}

/* --- EEPROM and power --- */

static int open_memory(struct lx_can_node *self, void (*settled)(void *ctx, dg_ns now),
                       struct lx_error *error)
{
    const struct lx_bus_setup *bus = &self->bus->bus.setup;
    const struct lx_plan_encoder *plan = self->station->plan;
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
        .stack = &dg_cia406_stack,
        .device = {.model = &self->model,
                   .serial = self->station->control.serial,
                   .address = self->id},
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

/* A file may know a node-ID that was set over the bus. */
static void tell_node_id(const struct lx_can_node *self)
{
    if (self->device.node.mounted && self->device.node.id != self->id) {
        lx_note(self->bus->bus.setup.say, "%s: its node-ID is %u, not %u", self->station->plan->nvm,
                self->device.node.id, self->id);
    }
}

static bool was_shared(const struct lx_can_node *self, uint16_t id)
{
    size_t i = 0;
    while (i < DG_CO_SHARED_MAX && self->shared[i] != id) {
        i++;
    }
    return i < DG_CO_SHARED_MAX;
}

void lx_can_tell_shared(struct lx_can_node *self)
{
    const struct dg_co_node *node = &self->device.node;
    uint16_t ids[DG_CO_SHARED_MAX] = {0};
    if (self->shared_version == node->filter_version) {
        return;
    }
    self->shared_version = node->filter_version;
    const uint8_t count = dg_co_shared_ids(node, ids);
    for (uint8_t i = 0; i < count; i++) {
        if (!was_shared(self, ids[i])) {
            lx_note(self->bus->bus.setup.say,
                    "%s/%u: two services of this node have the CAN-ID %03Xh, both send",
                    self->bus->can->address, node->id, ids[i]);
        }
    }
    memcpy(self->shared, ids, sizeof ids);
}

static int power_on(struct lx_can_node *self, const struct dg_co_ops *ops, dg_ns now,
                    struct lx_error *error)
{
    const struct dg_co_setup device = {
        .device = self->model.device,
        .world = &self->station->world,
        .nvm = self->station->control.nvm,
        .ops = ops,
        .ctx = self,
        .application = &self->device.encoder,
    };
    if (dg_co_init(&self->device.node, &device) != DG_OK ||
        dg_co_power_on(&self->device.node, now) != DG_OK) {
        return lx_fail(error, "the encoder does not start: not its EEPROM");
    }
    self->station->control.device = &self->device;
    return 0;
}

int lx_can_node_open(struct lx_can_node *self, const struct dg_co_ops *ops,
                     void (*settled)(void *ctx, dg_ns now), dg_ns now, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus->bus.setup;
    const struct lx_plan_encoder *plan = self->station->plan;
    if (dg_cia406_init(&self->device.encoder, &self->model) != DG_OK) {
        (void)lx_fail(error, "these factory figures make no encoder");
        return lx_stands(error, setup->plan->file, plan->line);
    }
    if (open_memory(self, settled, error) != 0 || power_on(self, ops, now, error) != 0) {
        return lx_plan_refuse_key(setup->plan, "nvm", plan->nvm_line, error);
    }
    tell_node_id(self);
    return 0;
}

void lx_can_node_close(struct lx_can_node *self)
{
    dg_co_power_off(&self->device.node);
    lx_image_close(&self->image);
    free(self->answers.frames);
}
