/* SPDX-License-Identifier: MIT */
/* RS485 encoders on one port: from the plan to a line, see hf_line.c. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "figure.h"
#include "hf_line.h"

static struct lx_hf_bus *hf_of(struct lx_bus *bus)
{
    return (struct lx_hf_bus *)bus;
}

/* --- the operations --- */

/* Nine digits. */
static uint32_t serial_of(const struct dg_hf_model *model)
{
    uint64_t serial = 0;
    return lx_unsigned_parse(model->serial, &serial) ? (uint32_t)serial : 0;
}

static int open_memory(struct lx_hf_drop *self, struct lx_error *error)
{
    const struct lx_bus_setup *bus = &self->all->bus.setup;
    const struct lx_plan_encoder *plan = self->station->plan;
    const struct lx_image_setup image = {
        .path = plan->nvm,
        .answer = "the encoder answers 05h",
        .parts = &self->memory,
        .count = 1,
        .say = bus->say,
        .writer = bus->writer,
        .settled = lx_hf_on_settled,
        .ctx = self,
    };
    self->memory = (struct lx_image_part){
        .stack = &dg_hf_stack,
        .device = {.model = &self->settings.encoder.model,
                   .serial = serial_of(&self->settings.encoder.model),
                   .address = self->settings.encoder.address},
        .serial_given = self->settings.serial_given,
    };
    if (lx_image_open(&self->image, &image, error) != 0 ||
        lx_image_start(&self->image, error) != 0) {
        return lx_plan_refuse_key(bus->plan, "nvm", plan->nvm_line, error);
    }
    self->station->control.nvm = self->memory.device.nvm;
    self->station->queue = lx_image_queue(&self->image);
    return 0;
}

/* What was set over the line stays. */
static void tell_address(const struct lx_hf_drop *self)
{
    const uint32_t wanted = self->settings.encoder.address;
    if (wanted != 0 && self->device.address != wanted &&
        !dg_store_damaged(&self->device.store, DG_HF_REGION_UART)) {
        lx_note(self->all->bus.setup.say, "%s: its address is 0x%02X, not 0x%02X",
                self->station->plan->nvm, self->device.address, wanted);
    }
}

static int switch_on(struct lx_hf_drop *self, dg_ns now, struct lx_error *error)
{
    struct lx_station *station = self->station;
    if (open_memory(self, error) != 0) {
        return -1;
    }
    const struct dg_hf_setup device = {
        .model = &self->settings.encoder.model,
        .world = &station->world,
        .nvm = station->control.nvm,
        .ops = &lx_hf_device_ops,
        .ctx = self,
    };
    if (dg_hf_init(&self->device, &device) != DG_OK ||
        dg_hf_power_on(&self->device, now) != DG_OK) {
        return lx_fail(error, "the encoder does not start: not its EEPROM");
    }
    station->control.device = &self->device;
    tell_address(self);
    self->uart = dg_hf_uart(&self->device);
    const struct lx_uart uart = lx_hf_uart(&self->uart);
    lx_line_set(&self->line, &uart);
    return 0;
}

static bool nobody_asks(const struct lx_hf_bus *self)
{
    for (size_t i = 0; i < self->count; i++) {
        if (!self->drop[i].settings.any_line) {
            return false;
        }
    }
    return true;
}

static bool nobody_hurries(const struct lx_hf_bus *self)
{
    for (size_t i = 0; i < self->count; i++) {
        if (!self->drop[i].settings.pace) {
            return false;
        }
    }
    return true;
}

static int open_line(struct lx_hf_bus *self, struct lx_error *error)
{
    const struct lx_bus_setup *bus = &self->bus.setup;
    /* A stored setting that cannot be decoded leaves the one in force. */
    struct dg_hf_uart stored = self->drop->uart;
    (void)dg_hf_uart_decode(self->drop->device.uart_stored, &stored);
    const struct lx_serial_setup setup = {
        .event = bus->event,
        .silkit = bus->silkit,
        .say = bus->say,
        .where = bus->wire->where,
        .uart = lx_hf_uart(&self->drop->uart),
        .found_baud = stored.baud,
        .any_line = nobody_asks(self),
        .rx = lx_hf_on_character,
        .ctx = self,
    };
    const int result = lx_timer_open(&self->timer, bus->event, lx_hf_on_time, self);
    if (result < 0) {
        return lx_fail(error, "no timer: %s", strerror(-result));
    }
    self->port = self->open(&setup, error);
    if (self->port == NULL) {
        return -1;
    }
    self->paced = !self->port->timed && nobody_hurries(self);
    return 0;
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct lx_hf_bus *self = hf_of(bus);
    for (size_t i = 0; i < self->count; i++) {
        if (switch_on(&self->drop[i], now, error) != 0) {
            return -1;
        }
    }
    if (open_line(self, error) != 0) {
        return -1;
    }
    /* The first deadline: the end of the start-up window. */
    for (size_t i = 0; i < self->count; i++) {
        lx_hf_follow(&self->drop[i], dg_hf_step(&self->drop[i].device, now));
    }
    lx_hf_settle(self);
    return 0;
}

static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    (void)station;
    (void)snprintf(to, size, "%s", ((const struct lx_hf_bus *)bus)->port->address);
}

/* A reply ends with the power. */
static void changed_one(struct lx_hf_drop *self, dg_ns now)
{
    if (!lx_hf_powered(self)) {
        lx_line_stop(&self->line);
        self->held.length = 0;
        self->again = false;
        self->deaf = false;
    }
    lx_hf_follow(self, dg_hf_step(&self->device, now));
}

static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct lx_hf_bus *self = hf_of(bus);
    for (size_t i = 0; i < self->count; i++) {
        if (station == NULL || station == self->drop[i].station) {
            changed_one(&self->drop[i], now);
        }
    }
    lx_hf_settle(self);
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct lx_hf_bus *self = (const struct lx_hf_bus *)bus;
    const struct lx_hf_drop *drop = station->own;
    const struct lx_count rows[] = {
        {"wire_up", lx_serial_up(self->port)}, {"wire_late", bus->late + bus->stalls},
        {"wire_collided", self->collided},     {"wire_lost", self->port->counters.lost},
        {"wire_baud", drop->uart.baud},        {"wire_overrun", self->overrun},
    };
    lx_bus_count(to, rows, DG_COUNT(rows));
}

static void close_bus(struct lx_bus *bus)
{
    struct lx_hf_bus *self = hf_of(bus);
    for (size_t i = 0; i < self->count; i++) {
        dg_hf_power_off(&self->drop[i].device);
        lx_image_close(&self->drop[i].image);
    }
    lx_serial_close(self->port);
    lx_timer_close(&self->timer);
    free(self);
}

static const struct lx_bus_ops ops = {LX_BUS_OPERATIONS};

/* --- from the plan --- */

static int place(struct lx_hf_bus *self, size_t index, struct lx_error *error)
{
    struct lx_station *station = self->bus.setup.stations[index];
    struct lx_hf_drop *drop = &self->drop[index];
    *drop = (struct lx_hf_drop){
        .station = station,
        .all = self,
        .device = {.line = DG_HF_OFF, .deadline = DG_NEVER},
        .deadline = DG_NEVER,
        .flipped = -1,
    };
    const struct lx_plan_encoder *plan = station->plan;
    if (lx_stack_settings(self->bus.setup.plan, self->bus.setup.wire, plan, &drop->settings,
                          &station->world, error) != 0) {
        return -1;
    }
    drop->settings.serial_given = plan->serial != NULL;
    drop->settings.encoder.address =
        plan->address == LX_PLAN_AS_DELIVERED ? 0 : (uint32_t)plan->address;
    station->own = drop;
    self->names[index] = station->control.name;
    return 0;
}

static struct lx_bus *make(const struct lx_bus_setup *setup, lx_serial_open *open,
                           struct lx_error *error)
{
    struct lx_hf_bus *self = calloc(1, sizeof *self + setup->count * sizeof self->drop[0]);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %zu encoders", setup->count);
        return NULL;
    }
    self->bus = (struct lx_bus){.ops = &ops, .setup = *setup};
    self->open = open;
    self->count = setup->count;
    self->bus.tap.encoders = self->names;
    self->bus.tap.encoder_count = self->count;
    for (size_t i = 0; i < self->count; i++) {
        if (place(self, i, error) != 0) {
            free(self);
            return NULL;
        }
    }
    return &self->bus;
}

struct lx_bus *lx_hf_bus_make_pty(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return make(setup, lx_pty_open, error);
}

struct lx_bus *lx_hf_bus_make_tty(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return make(setup, lx_tty_open, error);
}

struct lx_bus *lx_hf_bus_make_net(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return lx_net_port_check(setup->wire->where, error) == 0 ? make(setup, lx_net_port_open, error)
                                                             : NULL;
}

struct lx_bus *lx_hf_bus_make_silkit(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return make(setup, lx_silkit_serial_open, error);
}
