/* SPDX-License-Identifier: MIT */
/*
 * A ring of INTERBUS encoders behind a Modbus/TCP coupler, as a bus. Its master is the library's.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus.h"
#include "drehgeber/interbus.h"
#include "modbus.h"
#include "ring_silkit.h"
#include "stacks.h"
#include "trace_format.h"

struct ring_bus {
    struct lx_bus bus;
    struct lx_ring ring;
    struct dg_ib_model ignored; /* what is said of the turns of a K1, which has none */
    struct lx_modbus coupler;
    bool coupled;                 /* the coupler was opened */
    struct lx_ring_silkit silkit; /* driven: there is none, a simulation lets it cycle */
};

static struct ring_bus *ring_of(struct lx_bus *bus)
{
    return (struct ring_bus *)bus;
}

/* --- the operations --- */

/* Whoever listens wants each cycle. In a simulation there is nothing but that. */
static void wake_ring(struct ring_bus *self, dg_ns now)
{
    dg_ring_master_changed(&self->ring.master, lx_tap_on(&self->bus.tap), now);
    if (self->coupled) {
        lx_modbus_sleep(&self->coupler);
    }
}

/* IN words that were held back come with the next cycle. */
static void on_settled(void *ctx, dg_ns now)
{
    wake_ring(ctx, now);
}

static int open_ring_topics(struct ring_bus *self, struct lx_error *error)
{
    self->silkit.ring = &self->ring;
    return lx_ring_silkit_open(&self->silkit, &self->bus.setup, error);
}

static int open_coupler(struct ring_bus *self, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    const struct lx_modbus_setup coupler = {
        .event = setup->event,
        .say = setup->say,
        .where = setup->wire->where,
        .master = &self->ring.master,
        .tear = dg_engine_wire_of(setup->engine, setup->index)->line.ring.tear,
    };
    self->coupled = true;
    return lx_modbus_open(&self->coupler, &coupler, error);
}

/* A file that several may share stands where the first of them names it. */
static int place_nvm(const struct lx_bus_setup *setup, const char *refused, struct lx_error *error)
{
    for (size_t i = 0; refused != NULL && i < setup->count; i++) {
        const struct dg_plan_encoder *plan = setup->stations[i]->plan;
        if (plan->nvm != NULL && strcmp(plan->nvm, refused) == 0) {
            return lx_plan_stands(setup->plan, plan->nvm_line, error);
        }
    }
    return -1;
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct ring_bus *self = ring_of(bus);
    const struct lx_bus_setup *setup = &bus->setup;
    const struct lx_ring_setup ring = {
        .bus = setup,
        .core = bus->core,
        .tap = &bus->tap,
        .cycle = DG_US(dg_engine_wire_of(setup->engine, setup->index)->line.ring.cycle_us),
        .settled = on_settled,
        .ctx = self,
    };
    if (lx_ring_open(&self->ring, &ring, now, error) != 0) {
        return place_nvm(setup, self->ring.refused, error);
    }
    if ((setup->door->driven ? open_ring_topics : open_coupler)(self, error) != 0) {
        return -1;
    }
    wake_ring(self, now);
    return 0;
}

static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    const struct ring_bus *self = (const struct ring_bus *)bus;
    (void)snprintf(to, size, "%s/%zu",
                   bus->setup.door->driven ? self->silkit.where.ready : self->coupler.peers.address,
                   station->place);
}

static void look_at_ring(struct lx_bus *bus, dg_ns now)
{
    struct ring_bus *self = ring_of(bus);
    dg_ring_master_to(&self->ring.master, now);
    bus->late = self->ring.master.missed;
    if (self->coupled) {
        lx_modbus_sleep(&self->coupler);
    }
}

/* Power and worlds are looked at in the next cycle. */
static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct ring_bus *self = ring_of(bus);
    dg_bus_watch(bus->core, lx_tap_on(&bus->tap));
    look_at_ring(bus, now); /* what is over was not bent by what comes now */
    if (station != NULL) {
        (void)dg_bus_changed(bus->core, station->place, now);
    }
    wake_ring(self, now);
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct ring_bus *self = (const struct ring_bus *)bus;
    const struct dg_ring_counters *ring = &dg_ring_state(bus->core)->counters;
    (void)station;
    dg_state_number(to, "wire_up", bus->setup.door->driven || self->coupler.peers.listener >= 0);
    dg_state_number(to, "wire_late", bus->late + bus->stalls);
    dg_state_number(to, "wire_cycles", ring->cycles);
    dg_state_number(to, "wire_ids", ring->ids);
    dg_state_number(to, "wire_crc_errors", ring->crc_errors);
    dg_state_number(to, "wire_interrupted", ring->interrupted);
    dg_state_number(to, "wire_requests", self->coupler.requests);
}

static void close_bus(struct lx_bus *bus)
{
    struct ring_bus *self = ring_of(bus);
    if (self->coupled) {
        lx_modbus_close(&self->coupler);
    }
    lx_ring_close(&self->ring);
    free(self);
}

/* --- the protocol --- */

const struct lx_stack lx_ib_stack = {
    .core = &dg_ib_stack,
    .handle = &dg_ib_wire,
    .trace = &(const struct lx_trace_kind){"INTERBUS", {&lx_trace_csv}, false},
    .wire = "modbus",
    .spoiled = "the encoder answers 86000000h",
    .is_ring = true,
};

static const struct lx_bus_ops bus_ops = {
    LX_BUS_OPERATIONS,
    .look = look_at_ring,
    .turns = look_at_ring,
};

/* --- from the plan --- */

/* As one of a ring a K1 takes turns and leaves them. */
static void place_ring_encoder(struct ring_bus *self, struct lx_station *station)
{
    const struct dg_ib_model *model = dg_host_line_of(station->host)->settings;
    if (model->profile == DG_IB_K1) {
        station->rows = (struct dg_keys){dg_keys_find(&dg_ib_keys, "turns"), 1};
        station->base = &self->ignored;
    }
}

struct lx_bus *lx_ring_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                struct lx_error *error)
{
    struct ring_bus *self = lx_bus_allocate(sizeof *self, &bus_ops, setup, error);
    if (self == NULL) {
        return NULL;
    }
    for (size_t i = 0; i < setup->count; i++) {
        place_ring_encoder(self, setup->stations[i]);
    }
    to->ops = &lx_ring_ops;
    to->ctx = &self->ring;
    return &self->bus;
}
