/* SPDX-License-Identifier: MIT */
/* Lines of a plan: the door of a bus of the library, each encoder with its EEPROM. */
#include "clocked.h"

#include <stdlib.h>

/* --- the bus --- */

static void take_level(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct lx_clocked *self = ctx;
    (void)place;
    self->data = event->levels.data;
}

static void tell_levels(void *ctx, const struct dg_tap_event *event)
{
    const struct lx_clocked *self = ctx;
    lx_tap_tell(self->tap, event);
}

static enum dg_bus_answer answer(void *ctx, size_t place)
{
    const struct lx_clocked *self = ctx;
    struct lx_nvm_queue *queue = self->queue[place];
    return queue == NULL ? DG_BUS_SAY : lx_nvm_queue_answer(queue);
}

void lx_clocked_hold(struct lx_clocked *self, size_t index, struct lx_nvm_queue *queue)
{
    self->queue[index] = queue;
    self->ops.answer = answer;
}

void lx_clocked_listen(struct lx_clocked *self)
{
    dg_bus_watch(self->bus, lx_tap_on(self->tap));
}

void lx_clocked_connect(struct lx_clocked *self, struct dg_bus *bus, const struct lx_tap *tap)
{
    self->tap = tap;
    self->bus = bus;
    self->count = dg_bus_count(bus);
    self->data = dg_bus_edges_data(bus, 0);
}

void lx_clocked_look(struct lx_clocked *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        (void)dg_bus_changed(self->bus, i, now);
    }
}

/* --- from a plan --- */

struct lx_clocked *lx_clocked_new(const struct lx_clocked_protocol *protocol)
{
    struct lx_clocked *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->protocol = protocol;
        self->ops.tx = take_level;
        self->ops.tap = tell_levels;
    }
    return self;
}

/* What the port has of its settings. */
static void place_clocked_encoder(struct lx_clocked *self, size_t index)
{
    struct lx_station *station = self->station[index];
    const struct lx_stack *stack = lx_stack_of(station->plan->model);
    void *settings = dg_host_line_of(station->host)->settings;
    if (stack->instead != NULL) {
        station->rows = (struct dg_keys){stack->instead, 1};
        station->base = settings;
    }
    if (self->master == LX_CLOCKED_HERE) {
        station->control->port = self->protocol->port;
        station->control->port_ctx = station;
        return;
    }
    lx_clocked_hold(self, index, &station->image.queue);
    if (self->protocol->slow_down != NULL) {
        self->protocol->slow_down(settings);
    }
}

struct lx_clocked *lx_clocked_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                   enum lx_clocked_master master, struct lx_error *error)
{
    const struct dg_device *first = setup->stations[0]->plan->model;
    const struct lx_clocked_protocol *protocol = lx_stack_of(first)->clocked;
    if (protocol == NULL) {
        (void)lx_fail(error, "%s cannot be on this wire", first->name);
        return NULL;
    }
    struct lx_clocked *self = lx_clocked_new(protocol);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %zu encoders", setup->count);
        return NULL;
    }
    self->master = master;
    self->station = setup->stations;
    self->count = setup->count;
    for (size_t i = 0; i < setup->count; i++) {
        place_clocked_encoder(self, i);
    }
    to->ops = &self->ops;
    to->ctx = self;
    return self;
}

static const void *settings_of(const struct lx_station *station)
{
    return dg_host_line_of(station->host)->settings;
}

int lx_clocked_check(const struct lx_clocked *self, const struct lx_bus_setup *setup,
                     const struct lx_station *station, struct lx_error *error)
{
    return self->protocol->check == NULL
               ? 0
               : self->protocol->check(setup, station, self->master, error);
}

int lx_clocked_check_rate(const struct lx_clocked *self, uint32_t hz, struct lx_error *error)
{
    int result = 0;
    for (size_t i = 0; self->protocol->check_rate != NULL && result == 0 && i < self->count; i++) {
        result = self->protocol->check_rate(settings_of(self->station[i]), hz, error);
    }
    return result;
}

dg_ns lx_clocked_init(const struct lx_clocked *self)
{
    dg_ns longest = 0;
    for (size_t i = 0; self->protocol->init != NULL && i < self->count; i++) {
        const dg_ns init = self->protocol->init(settings_of(self->station[i]));
        longest = init > longest ? init : longest;
    }
    return longest;
}

int lx_clocked_open(struct lx_clocked *self, const struct lx_bus_setup *setup, struct dg_bus *bus,
                    const struct lx_tap *tap, dg_ns now, struct lx_error *error)
{
    for (size_t i = 0; i < self->count; i++) {
        if (lx_station_open(self->station[i], setup, NULL, NULL, now, error) != 0) {
            return -1;
        }
    }
    lx_clocked_connect(self, bus, tap);
    lx_clocked_look(self, now);
    self->data = dg_bus_edges_data(bus, now);
    return 0;
}

void lx_clocked_close(struct lx_clocked *self)
{
    for (size_t i = 0; self != NULL && self->station != NULL && i < self->count; i++) {
        lx_station_close(self->station[i]);
    }
    free(self);
}

dg_ns lx_clocked_hint(struct lx_clocked *self, const struct lx_say *say, const char *name,
                      dg_ns now)
{
    dg_ns due = DG_NEVER;
    const char *text = dg_bus_edges_hint(self->bus, now, &due);
    if (text != NULL) {
        lx_note(say, "%s: %s", name, text);
    }
    return due;
}
