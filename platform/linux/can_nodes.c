/* SPDX-License-Identifier: MIT */
/*
 * The core says what is next, this file makes it happen:
 *
 *   bus ---- on_frame -----> dg_co_net_rx() --\
 *   bus ---- on_bus -------> dg_co_net_bus() --> settle(): deadlines, filters, bit rates
 *   timer -- settle -------> dg_co_net_step() -/
 *                                   \-- send_frame --> bus
 *
 * A node whose bit rate is not the wire's lives on, but outside the net: deaf and mute.
 */
#define _GNU_SOURCE
#include "can_nodes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- what the nodes do to the bus --- */

static void send_frame(void *ctx, const struct dg_can_frame *frame)
{
    const struct lx_can_node *node = ctx;
    if (node->hears) {
        lx_can_send(node->all->bus, frame);
    }
}

static bool hears(const struct lx_can_node *node)
{
    const struct lx_can *bus = node->all->bus;
    return bus->ops->hears == NULL || bus->ops->hears(bus, node->kbaud);
}

/* Called inside the core: whether the node still hears is settled after that, but what it sends
   from here on already is at its new rate. */
static void use_bit_rate(void *ctx, uint16_t kbaud)
{
    struct lx_can_node *node = ctx;
    node->kbaud = kbaud;
    node->all->bus->ops->expect(node->all->bus, kbaud);
    node->all->retuned = true;
    node->hears = hears(node);
}

static const struct dg_co_ops node_ops = {.send = send_frame, .bit_rate = use_bit_rate};

/* --- what the bus and the time do to the nodes --- */

/* The net of those that hear the wire; on one that has no rate of its own, of all. */
static void tune(struct lx_can_nodes *self)
{
    for (unsigned i = 0; i < self->count; i++) {
        const bool now = hears(&self->node[i]);
        self->retuned = self->retuned || now != self->node[i].hears;
        self->node[i].hears = now;
    }
    if (!self->retuned) {
        return;
    }
    self->retuned = false;
    self->told = false;
    dg_co_net_init(&self->net);
    for (unsigned i = 0; i < self->count; i++) {
        if (self->node[i].hears) {
            (void)dg_co_net_add(&self->net, &self->node[i].device);
        }
    }
}

/* What is due. @return the next deadline */
static dg_ns step(struct lx_can_nodes *self, dg_ns now)
{
    dg_ns next = dg_co_net_step(&self->net, now);
    for (unsigned i = 0; i < self->count; i++) {
        if (!self->node[i].hears) {
            next = dg_earliest(next, dg_co_step(&self->node[i].device, now));
        }
    }
    return next;
}

static void tell_filters(struct lx_can_nodes *self)
{
    const size_t size = sizeof self->filter_version;
    if (self->bus->ops->filter == NULL ||
        (self->told && memcmp(self->filter_version, self->net.filter_version, size) == 0)) {
        return;
    }
    memcpy(self->filter_version, self->net.filter_version, size);
    self->told = true;
    self->bus->ops->filter(self->bus, &self->net);
}

/* After everything that happened to the nodes. While the bus is stalled nothing is due. */
static void settle(void *ctx, dg_ns now)
{
    struct lx_can_nodes *self = ctx;
    dg_ns next = DG_NEVER;
    do {
        tune(self);
        next = self->bus->stalled ? DG_NEVER : step(self, now);
    } while (self->retuned);
    tell_filters(self);
    lx_timer_at(&self->timer, self->bus->stalled ? DG_NEVER : next);
}

static void on_frame(void *ctx, dg_ns now, const struct dg_can_frame *frame)
{
    struct lx_can_nodes *self = ctx;
    (void)dg_co_net_rx(&self->net, now, frame);
}

static void on_bus(void *ctx, dg_ns now, enum dg_co_bus_event event)
{
    struct lx_can_nodes *self = ctx;
    (void)dg_co_net_bus(&self->net, now, event);
}

/* --- power --- */

/* The delivery state with this node-ID. */
static int deliver(struct lx_can_node *node, const struct dg_co_device *device, uint32_t serial,
                   uint8_t id)
{
    struct dg_store store;
    uint8_t bus[3] = {0}; /* bit rate, node-ID, termination */
    if (lx_nvm_memory_init(&node->memory, dg_store_size(device->layout)) != 0) {
        return DG_ERR_SPACE;
    }
    const struct dg_nvm nvm = lx_nvm_memory_port(&node->memory);
    int result = dg_co_format(device, nvm, serial);
    if (result == DG_OK) {
        result = dg_store_mount(&store, device->layout, nvm);
    }
    if (result == DG_OK) {
        result = dg_store_read(&store, DG_CO_REGION_BUS, 0, bus, sizeof bus);
    }
    bus[1] = id;
    return result == DG_OK ? dg_store_put(&store, DG_CO_REGION_BUS, 0, bus, sizeof bus) : result;
}

/* Its EEPROM: in memory, or FILE, or FILE.NODE when there are several. */
static int open_eeprom(struct lx_can_node *node, uint8_t id, struct dg_nvm *nvm,
                       struct lx_error *error)
{
    const struct lx_can_nodes_setup *setup = &node->all->setup;
    *nvm = lx_nvm_memory_port(&node->memory);
    if (setup->nvm == NULL) {
        return 0;
    }
    const int n = node->all->count == 1 ? asprintf(&node->path, "%s", setup->nvm)
                                        : asprintf(&node->path, "%s.%u", setup->nvm, id);
    if (n < 0) {
        node->path = NULL;
        return lx_fail(error, "no memory for the EEPROM");
    }
    const struct lx_nvm_image image = {node->memory.bytes, node->memory.size};
    if (lx_nvm_file_open(&node->file, node->path, &image, error) != 0) {
        return -1;
    }
    *nvm = lx_nvm_file_port(&node->file);
    return 0;
}

/* A file may belong to another encoder, or know a node-ID that was set over the bus. */
static int check_eeprom(const struct lx_can_node *node, uint32_t serial, uint8_t id,
                        struct lx_error *error)
{
    const struct lx_can_nodes_setup *setup = &node->all->setup;
    if (!node->device.mounted) { /* an EEPROM that does not answer belongs to nobody */
        return 0;
    }
    if (setup->serial_given && node->device.serial != serial) {
        return lx_fail(error,
                       "%s: belongs to serial number %lu; run that one, or give the name of a new "
                       "file",
                       node->path, (unsigned long)node->device.serial);
    }
    if (node->device.id != id) {
        lx_note(setup->say, "%s: its node-ID is %u, not %u", node->path, node->device.id, id);
    }
    return 0;
}

static int power_on(struct lx_can_node *node, uint8_t id, dg_ns now, struct lx_error *error)
{
    const struct lx_can_nodes_setup *setup = &node->all->setup;
    const uint32_t serial = setup->serial + (uint32_t)(id - setup->first);
    struct dg_co_setup device = {
        .device = setup->model->device,
        .world = setup->world,
        .ops = &node_ops,
        .ctx = node,
        .application = &node->encoder,
    };
    if (dg_cia406_init(&node->encoder, setup->model) != DG_OK ||
        deliver(node, device.device, serial, id) != DG_OK) {
        return lx_fail(error, "these factory figures make no encoder, or there is no memory");
    }
    if (open_eeprom(node, id, &device.nvm, error) != 0) {
        return -1;
    }
    if (dg_co_init(&node->device, &device) != DG_OK ||
        dg_co_power_on(&node->device, now) != DG_OK) {
        return lx_fail(error,
                       "%s: no image of this kind of encoder; give a file made by drehgeber, or "
                       "the name of a new one",
                       node->path == NULL ? "EEPROM" : node->path);
    }
    return check_eeprom(node, serial, id, error);
}

int lx_can_nodes_open(struct lx_can_nodes *self, const struct lx_can_nodes_setup *setup, dg_ns now,
                      struct lx_error *error)
{
    const struct lx_can_setup bus = {
        .event = setup->event,
        .say = setup->say,
        .where = setup->where,
        .rx = on_frame,
        .bus = on_bus,
        .settle = settle,
        .ctx = self,
    };
    *self = (struct lx_can_nodes){.setup = *setup, .count = setup->last - setup->first + 1u};
    dg_co_net_init(&self->net);
    self->node = calloc(self->count, sizeof *self->node);
    if (self->node == NULL) {
        return lx_fail(error, "no memory for %u encoders", self->count);
    }
    for (unsigned i = 0; i < self->count; i++) {
        self->node[i].all = self;
        self->node[i].file.fd = -1;
    }
    const int result = lx_timer_open(&self->timer, setup->event, settle, self);
    if (result < 0) {
        return lx_fail(error, "no timer: %s", strerror(-result));
    }
    self->bus = setup->open(&bus, error);
    if (self->bus == NULL) {
        return -1;
    }
    for (unsigned i = 0; i < self->count; i++) {
        if (power_on(&self->node[i], (uint8_t)(setup->first + i), now, error) != 0) {
            return -1;
        }
    }
    settle(self, now);
    return 0;
}

void lx_can_nodes_close(struct lx_can_nodes *self)
{
    for (unsigned i = 0; self->node != NULL && i < self->count; i++) {
        struct lx_can_node *node = &self->node[i];
        dg_co_power_off(&node->device);
        lx_nvm_file_close(&node->file);
        lx_nvm_memory_free(&node->memory);
        free(node->path);
    }
    lx_can_close(self->bus);
    lx_timer_close(&self->timer);
    free(self->node);
    *self = (struct lx_can_nodes){.count = 0};
}
