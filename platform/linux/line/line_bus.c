/* SPDX-License-Identifier: MIT */
/* Encoders that speak in characters on one port: from the plan to a line, see line_master.c. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "line_bus.h"

static struct lx_line_bus *line_bus_of(struct lx_bus *bus)
{
    return (struct lx_line_bus *)bus;
}

/* --- the operations --- */

/* What was set over the line stays. */
static void report_encoder_address(const struct lx_line_encoder *self)
{
    const struct dg_bus_side *side = dg_host_side_at(self->station->host);
    const int wanted = self->station->plan->address;
    const int found =
        side->address != NULL ? side->address(dg_host_line_of(self->station->host)) : -1;
    if (wanted != DG_PLAN_AS_DELIVERED && found >= 0 && found != wanted) {
        lx_note(self->all->bus.setup.say, "%s: its address is 0x%02X, not 0x%02X",
                self->station->plan->nvm, (unsigned)found, (unsigned)wanted);
    }
}

static int switch_encoder_on(struct lx_line_encoder *self, dg_ns now, struct lx_error *error)
{
    if (lx_station_open(self->station, &self->all->bus.setup, lx_line_on_settled, self, now,
                        error) != 0) {
        return -1;
    }
    report_encoder_address(self);
    return 0;
}

/* Its setting in force, or the stored one. */
static struct dg_host_uart uart_of(const struct lx_line_encoder *self, bool stored)
{
    struct dg_host_uart uart = {0};
    dg_host_wire_at(self->station->host)->uart(dg_host_line_of(self->station->host), stored, &uart);
    return uart;
}

static bool nobody_asks(const struct lx_line_bus *self)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    bool any = true;
    for (size_t i = 0; i < self->count; i++) {
        const size_t index = lx_station_index(self->encoder[i].station, setup);
        any = any && dg_engine_end_of(setup->engine, index).any_line;
    }
    return any;
}

static int open_port(struct lx_line_bus *self, struct lx_error *error)
{
    const struct lx_bus_setup *bus = &self->bus.setup;
    const struct dg_host_uart uart = uart_of(self->encoder, false);
    const struct lx_serial_setup setup = {
        .event = bus->event,
        .silkit = bus->silkit,
        .say = bus->say,
        .where = bus->wire->where,
        .uart = lx_line_uart(&uart),
        .found_baud = uart_of(self->encoder, true).baud,
        .any_line = nobody_asks(self),
        .rx = lx_line_on_character,
        .ctx = self,
    };
    if (lx_timer_make(&self->timer, bus->event, lx_line_on_time, self, error) != 0) {
        return -1;
    }
    self->port = bus->door->open_port(&setup, error);
    return self->port == NULL ? -1 : 0;
}

/* The port is open: how it sends is known. @return when the encoders want to be called */
static dg_ns begin_serial_line(struct lx_line_bus *self, dg_ns now)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    dg_ns next = DG_NEVER;
    self->paced =
        !self->port->timed && dg_engine_wire_of(setup->engine, setup->index)->characters.paced;
    if (self->port->timed) {
        dg_bus_characters_whole(self->bus.core, lx_line_whole);
    }
    for (size_t i = 0; i < self->count; i++) {
        next = dg_bus_changed(self->bus.core, i, now);
    }
    return next;
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct lx_line_bus *self = line_bus_of(bus);
    for (size_t i = 0; i < self->count; i++) {
        if (switch_encoder_on(&self->encoder[i], now, error) != 0) {
            return -1;
        }
    }
    if (open_port(self, error) != 0) {
        return -1;
    }
    /* The first deadline: the end of the start-up window. */
    lx_line_settle(self, begin_serial_line(self, now));
    return 0;
}

static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    (void)station;
    (void)snprintf(to, size, "%s", ((const struct lx_line_bus *)bus)->port->address);
}

static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct lx_line_bus *self = line_bus_of(bus);
    lx_line_enter(self);
    for (size_t i = 0; i < self->count; i++) {
        if (station == NULL || station == self->encoder[i].station) {
            (void)dg_bus_changed(bus->core, i, now);
        }
    }
    lx_line_settle(self, dg_bus_next(bus->core));
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct lx_line_bus *self = (const struct lx_line_bus *)bus;
    const struct dg_characters_counters counted = dg_bus_characters_counters(bus->core);
    const struct dg_host_uart uart = dg_bus_characters_uart(bus->core, station->place);
    dg_state_number(to, "wire_up", lx_serial_up(self->port));
    dg_state_number(to, "wire_late", bus->late + bus->stalls);
    dg_state_number(to, "wire_collided", counted.collided);
    dg_state_number(to, "wire_lost", self->port->counters.lost);
    dg_state_number(to, "wire_baud", uart.baud);
    dg_state_number(to, "wire_overrun", counted.overrun);
}

/* Encoders first: what is written to a file may still lead to a reply. */
static void close_bus(struct lx_bus *bus)
{
    struct lx_line_bus *self = line_bus_of(bus);
    for (size_t i = 0; i < self->count; i++) {
        lx_station_close(bus->setup.stations[i]);
    }
    lx_serial_close(self->port);
    lx_timer_close(&self->timer);
    free(self);
}

static const struct lx_bus_ops ops = {LX_BUS_OPERATIONS};

/* --- from the plan --- */

static void place_line_encoder(struct lx_line_bus *self, size_t index)
{
    struct lx_station *station = self->bus.setup.stations[index];
    struct lx_line_encoder *encoder = &self->encoder[index];
    const struct lx_stack *stack = lx_stack_of(station->plan->model);
    *encoder = (struct lx_line_encoder){.station = station, .all = self};
    self->names[index] = station->control->name;
    self->bus.tap.baud = stack->baud > self->bus.tap.baud ? stack->baud : self->bus.tap.baud;
    if (stack->usual != NULL) {
        memcpy(&encoder->sincos, stack->usual, sizeof encoder->sincos);
        station->rows = stack->own;
        station->base = &encoder->sincos;
    }
}

struct lx_bus *lx_line_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                struct lx_error *error)
{
    struct lx_line_bus *self =
        lx_bus_allocate(sizeof *self + setup->count * sizeof self->encoder[0], &ops, setup, error);
    if (self == NULL) {
        return NULL;
    }
    self->count = setup->count;
    self->bus.tap.encoders = self->names;
    self->bus.tap.encoder_count = self->count;
    for (size_t i = 0; i < self->count; i++) {
        place_line_encoder(self, i);
    }
    to->ops = &lx_line_ops;
    to->ctx = self;
    to->characters.live = true;
    to->characters.late = LX_BUS_LATE;
    return &self->bus;
}
