/* SPDX-License-Identifier: MIT */
/*
 * Each K3 has its part of an image (a file), which several may share. A file that does not fit is
 * found before anything is written to any.
 */
#include "modbus_ring.h"

#include <stdlib.h>
#include <string.h>

static struct lx_station *station_at(const struct lx_ring *self, size_t index)
{
    return self->setup->stations[index];
}

/* --- memories --- */

static bool make_ring_room(struct lx_ring *self)
{
    self->part_of = calloc(self->count, sizeof(struct lx_image_part *));
    self->parts = calloc(self->count, sizeof *self->parts);
    self->stores = calloc(self->count, sizeof *self->stores);
    return self->part_of != NULL && self->parts != NULL && self->stores != NULL;
}

static bool same_path(const char *a, const char *b)
{
    return a == b || (a != NULL && b != NULL && strcmp(a, b) == 0);
}

/* The parts of the devices with this file, one of which is the first that has it; NULL: of those
   without. */
static void gather_memories(struct lx_ring *self, size_t first, struct lx_image_part *parts)
{
    struct lx_ring_store *store = &self->stores[self->store_count++];
    *store = (struct lx_ring_store){.path = station_at(self, first)->plan->nvm, .parts = parts};
    for (size_t i = first; i < self->count; i++) {
        if (!same_path(station_at(self, i)->plan->nvm, store->path)) {
            continue;
        }
        self->part_of[i] = &parts[store->count++];
        *self->part_of[i] = (struct lx_image_part){
            .stack = &dg_ib_stack,
            .device = {.model = dg_bus_settings(self->bus, i)},
            .place = i,
            .right = "a K1 has at most 65536 steps, one with steps_minus_one at least 2",
        };
    }
}

/* Which part of which memory is whose. */
static void assign_memories(struct lx_ring *self)
{
    size_t used = 0;
    for (size_t i = 0; i < self->count; i++) {
        if (self->part_of[i] == NULL) {
            gather_memories(self, i, &self->parts[used]);
            used += self->stores[self->store_count - 1].count;
        }
    }
}

static bool has_own_memory(const struct lx_ring_store *self)
{
    bool any = false;
    for (size_t i = 0; i < self->count; i++) {
        any = any || dg_ib_stack.layout(self->parts[i].device.model) != NULL;
    }
    return any;
}

static int open_store(struct lx_ring_store *self, const struct lx_ring_setup *setup,
                      struct lx_error *error)
{
    const struct lx_image_setup image = {
        .path = self->path,
        .answer = lx_ib_stack.spoiled,
        .parts = self->parts,
        .count = self->count,
        .say = setup->bus->say,
        .writer = setup->bus->writer,
        .settled = setup->settled,
        .ctx = setup->ctx,
    };
    if (self->path != NULL && !has_own_memory(self)) {
        (void)lx_refuse(error, "leave it out, or use a K3", "K1 and K2 have no EEPROM");
        return lx_about(error, LX_ABOUT_KEY, "nvm", self->path);
    }
    return lx_image_open(&self->image, &image, error);
}

/* Say whose file an error is about, if it is about one. */
static int refuse_file(struct lx_ring *self, const struct lx_ring_store *store,
                       struct lx_error *error)
{
    if (store->path == NULL || error->where.about == LX_ABOUT_ITSELF) {
        return -1;
    }
    self->refused = store->path;
    return lx_about(error, LX_ABOUT_KEY, "nvm", NULL);
}

/* Every file is looked at before the first one changes. */
static int open_stores(struct lx_ring *self, const struct lx_ring_setup *setup,
                       struct lx_error *error)
{
    for (size_t i = 0; i < self->store_count; i++) {
        if (open_store(&self->stores[i], setup, error) != 0) {
            return refuse_file(self, &self->stores[i], error);
        }
    }
    for (size_t i = 0; i < self->store_count; i++) {
        if (lx_image_start(&self->stores[i].image, error) != 0) {
            return refuse_file(self, &self->stores[i], error);
        }
    }
    return 0;
}

/* --- the ring --- */

static void tell_tap(void *ctx, const struct dg_tap_event *event)
{
    const struct lx_ring *self = ctx;
    lx_tap_tell(self->tap, event);
}

static uint64_t last_ticket(void *ctx, size_t place)
{
    const struct lx_ring *self = ctx;
    return self->part_of[place]->ticket;
}

static enum dg_bus_answer answer_now(void *ctx, size_t place)
{
    const struct lx_ring *self = ctx;
    const struct lx_image_part *part = self->part_of[place];
    return lx_nvm_answer_of(lx_nvm_queue_state(&part->image->queue, part->ticket));
}

const struct dg_bus_ops lx_ring_ops = {
    .tap = tell_tap,
    .answer = answer_now,
    .ticket = last_ticket,
};

static int switch_device_on(const struct lx_ring *self, size_t index, dg_ns now,
                            struct lx_error *error)
{
    struct lx_station *station = station_at(self, index);
    const struct dg_nvm *nvm = &self->part_of[index]->device.nvm;
    struct dg_plan_error ignored;
    if ((nvm->ops != NULL && dg_host_memory_port(station->host, nvm) != DG_HOST_OK) ||
        dg_engine_power_encoder(self->setup->engine, lx_station_index(station, self->setup), now,
                                &ignored) != 0) {
        return lx_fail(error, "device %zu does not start: not its EEPROM", index);
    }
    station->queue = nvm->ops == NULL ? NULL : lx_image_queue(self->part_of[index]->image);
    (void)dg_bus_changed(self->bus, index, now);
    return 0;
}

int lx_ring_open(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                 struct lx_error *error)
{
    memset(self, 0, sizeof *self);
    self->setup = setup->bus;
    self->tap = setup->tap;
    self->count = setup->bus->count;
    self->bus = setup->core;
    self->is = dg_ring_state(self->bus);
    const struct dg_ring_master_setup master = {sizeof master, self->bus, self->out, setup->cycle};
    dg_ring_master_init(&self->master, &master);
    dg_bus_watch(self->bus, lx_tap_on(self->tap));
    if (!make_ring_room(self)) {
        return lx_fail(error, "no memory for %zu devices", self->count);
    }
    assign_memories(self);
    int result = open_stores(self, setup, error);
    for (size_t i = 0; result == 0 && i < self->count; i++) {
        result = switch_device_on(self, i, now, error);
    }
    return result;
}

void lx_ring_close(struct lx_ring *self)
{
    for (size_t i = 0; i < self->store_count; i++) {
        lx_image_close(&self->stores[i].image);
    }
    free(self->stores);
    free(self->parts);
    free(self->part_of);
    memset(self, 0, sizeof *self);
}
