/* SPDX-License-Identifier: MIT */
/* An encoder of a CAN bus: the protocol, its numbers, what it tells of itself. */
#define _GNU_SOURCE
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "can_bus.h"
#include "drehgeber/cia406.h"
#include "trace_format.h"

/* --- the plan --- */

static uint32_t without(const struct dg_device *device)
{
    return dg_cia406_without(dg_cia406_model_of(device));
}

const struct lx_stack lx_cia406_stack = {
    .core = &dg_cia406_stack,
    .handle = &dg_cia406_wire,
    .trace = &(const struct lx_trace_kind){"CAN", {&lx_trace_log, &lx_trace_pcapng}, false},
    .wire = "slcan",
    .spoiled = "the encoder answers abort 06060000h",
    .without = without,
};

void lx_can_node_make(struct lx_can_bus *bus, size_t place)
{
    struct lx_station *station = bus->bus.setup.stations[place];
    bus->node[place] = (struct lx_can_node){
        .bus = bus,
        .station = station,
        .ask = dg_host_side_at(station->host)->controller,
        .device = dg_host_line_of(station->host)->device,
    };
}

/* --- what it is on the bus --- */

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

int lx_can_node_open(struct lx_can_node *self, void (*settled)(void *ctx, dg_ns now), dg_ns now,
                     struct lx_error *error)
{
    self->id = dg_host_setup(self->station->host).address;
    if (lx_station_open(self->station, &self->bus->bus.setup, settled, self, now, error) != 0) {
        return -1;
    }
    tell_node_id(self);
    return 0;
}
