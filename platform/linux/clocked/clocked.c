/* SPDX-License-Identifier: MIT */
/* Lines of a plan: handles on a bus of the library, each with its EEPROM. */
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

void lx_clocked_add(struct lx_clocked *self, struct dg_host *host, struct dg_encoder *control)
{
    self->host[self->count] = host;
    self->control[self->count++] = control;
}

/* All speak one protocol, and there is room for them: nothing is refused. */
void lx_clocked_connect(struct lx_clocked *self, const struct dg_bus_edges_setup *wire,
                        const struct lx_tap *tap)
{
    const struct dg_bus_setup setup = {
        .size = sizeof setup,
        .medium = &dg_bus_edges,
        .encoders = self->count,
        .wire = wire,
        .ops = &self->ops,
        .ctx = self,
    };
    self->tap = tap;
    self->ops.tap = tell_levels;
    self->bus = dg_bus_init(self->bus_memory, dg_bus_size(&dg_bus_edges, self->count), &setup);
    for (size_t i = 0; i < self->count; i++) {
        (void)dg_bus_attach(self->bus, self->host[i], self->control[i]);
    }
    self->data = dg_bus_edges_data(self->bus, 0);
}

void lx_clocked_look(struct lx_clocked *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        (void)dg_bus_changed(self->bus, i, now);
    }
}

void *lx_clocked_device(const struct lx_clocked *self, size_t index)
{
    return dg_host_line_of(self->host[index])->device;
}

/* --- from a plan --- */

static const struct lx_clocked_protocol *protocol_of(const struct lx_station *station)
{
    return lx_stack_of(station->plan->model)->clocked;
}

/* All have to speak the protocol of the first one. @return it, or NULL with `error` */
static const struct lx_clocked_protocol *choose(const struct lx_bus_setup *setup,
                                                struct lx_error *error)
{
    const struct lx_clocked_protocol *first = protocol_of(setup->stations[0]);
    for (size_t i = 0; i < setup->count; i++) {
        const struct dg_plan_encoder *encoder = setup->stations[i]->plan;
        if (first == NULL || protocol_of(setup->stations[i]) != first) {
            (void)lx_fail(error, "%s cannot be on this wire", encoder->model->name);
            (void)lx_plan_stands(setup->plan, encoder->line, error);
            return NULL;
        }
        if (i == first->encoders_max) {
            (void)lx_fail(error, "this wire is full: at most %zu encoders is right",
                          first->encoders_max);
            (void)lx_plan_stands(setup->plan, encoder->line, error);
            return NULL;
        }
    }
    return first;
}

struct lx_clocked *lx_clocked_new(const struct lx_clocked_protocol *protocol, size_t count)
{
    struct lx_clocked *self = calloc(1, protocol->size);
    if (self == NULL) {
        return NULL;
    }
    self->bus_memory = calloc(1, dg_bus_size(&dg_bus_edges, count));
    if (self->bus_memory == NULL) {
        free(self);
        return NULL;
    }
    self->protocol = protocol;
    self->ops.tx = take_level;
    return self;
}

static int place_all(struct lx_clocked *self, const struct lx_bus_setup *setup,
                     enum lx_clocked_master master, struct lx_error *error)
{
    for (size_t i = 0; i < setup->count; i++) {
        struct lx_station *station = setup->stations[i];
        self->station[i] = station;
        if (lx_station_make(station, setup, NULL, error) != 0) {
            return -1;
        }
        self->host[i] = station->host;
        if (self->protocol->suit(self, setup, i, master, error) != 0) {
            return -1;
        }
        if (master == LX_CLOCKED_THERE) {
            lx_clocked_hold(self, i, &station->image.queue);
        }
    }
    return 0;
}

struct lx_clocked *lx_clocked_make(const struct lx_bus_setup *setup, enum lx_clocked_master master,
                                   struct lx_error *error)
{
    const struct lx_clocked_protocol *protocol = choose(setup, error);
    if (protocol == NULL) {
        return NULL;
    }
    struct lx_clocked *self = lx_clocked_new(protocol, setup->count);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %zu encoders", setup->count);
        return NULL;
    }
    if (place_all(self, setup, master, error) != 0) {
        lx_clocked_close(self);
        return NULL;
    }
    return self;
}

int lx_clocked_check_rate(const struct lx_clocked *self, uint32_t hz, struct lx_error *error)
{
    return self->protocol->check_rate == NULL ? 0 : self->protocol->check_rate(self, hz, error);
}

int lx_clocked_open(struct lx_clocked *self, const struct lx_bus_setup *setup, size_t index,
                    dg_ns now, struct lx_error *error)
{
    struct lx_station *station = setup->stations[index];
    if (lx_station_open(station, setup, NULL, NULL, now, error) != 0) {
        return -1;
    }
    lx_clocked_add(self, station->host, &station->control);
    return 0;
}

void lx_clocked_close(struct lx_clocked *self)
{
    if (self == NULL) {
        return;
    }
    for (size_t i = 0; i < LX_CLOCKED_MAX && self->station[i] != NULL; i++) {
        lx_station_close(self->station[i]);
    }
    free(self->bus_memory);
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

void lx_clocked_offer(const struct lx_clocked *self, const struct lx_bus_setup *setup)
{
    for (size_t i = 0; i < setup->count && self->protocol->offer != NULL; i++) {
        self->protocol->offer(setup->stations[i]);
    }
}
