/* SPDX-License-Identifier: MIT */
/*
 * Each K3 has its part of an image (a file), which several may share. A file that does not fit is
 * found before anything is written to any.
 */
#include "modbus_ring.h"

#include <stdlib.h>
#include <string.h>

struct dg_nvm lx_ring_nvm(const struct lx_ring *self, size_t index)
{
    return self->part_of[index]->device.nvm;
}

const struct lx_nvm_queue *lx_ring_queue(const struct lx_ring *self, size_t index)
{
    return lx_image_queue(self->part_of[index]->image);
}

struct dg_ib *lx_ring_device(const struct lx_ring *self, size_t index)
{
    return dg_host_line_of(self->encoders[index])->device;
}

const struct dg_ib_model *lx_ring_model(const struct lx_ring *self, size_t index)
{
    return dg_host_line_of(self->encoders[index])->settings;
}

struct dg_world *lx_ring_world(const struct lx_ring *self, size_t index)
{
    return dg_host_world(self->encoders[index]);
}

/* In memory of its own. NULL: there is none. */
static struct dg_host *make_encoder(const struct lx_ring_member *member)
{
    const size_t size = dg_host_size_on_bus(member->device, &dg_ib_side);
    void *memory = aligned_alloc(DG_HOST_ALIGN, size);
    if (memory == NULL) {
        return NULL;
    }
    struct dg_host *encoder = dg_host_init_on_bus(memory, size, member->device, &dg_ib_side);
    *(struct dg_ib_model *)dg_host_line_of(encoder)->settings = member->model;
    *dg_host_world(encoder) = *member->world;
    return encoder;
}

static int make_encoders(struct lx_ring *self, const struct lx_ring_setup *setup,
                         struct lx_error *error)
{
    self->encoders = calloc(setup->count, sizeof(struct dg_host *));
    self->part_of = calloc(setup->count, sizeof(struct lx_image_part *));
    self->parts = calloc(setup->count, sizeof *self->parts);
    self->stores = calloc(setup->count, sizeof *self->stores);
    bool made = self->encoders != NULL && self->part_of != NULL && self->parts != NULL &&
                self->stores != NULL;
    for (; made && self->count < setup->count; self->count += made ? 1u : 0u) {
        self->encoders[self->count] = make_encoder(&setup->members[self->count]);
        made = self->encoders[self->count] != NULL;
    }
    return made ? 0 : lx_fail(error, "no memory for %zu devices", setup->count);
}

static bool same_path(const char *a, const char *b)
{
    return a == b || (a != NULL && b != NULL && strcmp(a, b) == 0);
}

/* The parts of the devices with this file, one of which is the first that has it; NULL: of those
   without. */
static void gather(struct lx_ring *self, const struct lx_ring_setup *setup, size_t first,
                   struct lx_image_part *parts)
{
    struct lx_ring_store *store = &self->stores[self->store_count++];
    *store = (struct lx_ring_store){.path = setup->members[first].nvm, .parts = parts};
    for (size_t i = first; i < setup->count; i++) {
        if (!same_path(setup->members[i].nvm, store->path)) {
            continue;
        }
        self->part_of[i] = &parts[store->count++];
        *self->part_of[i] = (struct lx_image_part){
            .stack = &dg_ib_stack,
            .device = {.model = lx_ring_model(self, i)},
            .place = i,
            .right = "a K1 has at most 65536 steps, one with steps_minus_one at least 2",
        };
    }
}

/* Which part of which memory is whose. */
static void share_out(struct lx_ring *self, const struct lx_ring_setup *setup)
{
    size_t used = 0;
    for (size_t i = 0; i < setup->count; i++) {
        if (self->part_of[i] == NULL) {
            gather(self, setup, i, &self->parts[used]);
            used += self->stores[self->store_count - 1].count;
        }
    }
}

static bool has_memory(const struct lx_ring_store *self)
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
        .say = setup->say,
        .writer = setup->writer,
        .settled = setup->settled,
        .ctx = setup->ctx,
    };
    if (self->path != NULL && !has_memory(self)) {
        (void)lx_refuse(error, "leave it out, or have a K3", "K1 and K2 have no EEPROM");
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

static const struct dg_bus_ops ring_ops = {
    .tap = tell_tap,
    .answer = answer_now,
    .ticket = last_ticket,
};

static int make_ring(struct lx_ring *self, struct lx_error *error)
{
    const struct dg_bus_words_setup wire = {
        .size = sizeof wire,
        .in = self->in,
        .words = LX_RING_WORDS_MAX,
        .identifies = true,
    };
    const struct dg_bus_setup setup = {
        .size = sizeof setup,
        .medium = &dg_bus_words,
        .encoders = self->count,
        .wire = &wire,
        .ops = &ring_ops,
        .ctx = self,
    };
    const size_t size = dg_bus_size(&dg_bus_words, self->count);
    if (size == 0) {
        return lx_fail(error, "a ring has 1 to %u devices, not %zu", DG_RING_MAX, self->count);
    }
    void *memory = aligned_alloc(DG_HOST_ALIGN, size);
    self->bus = memory != NULL ? dg_bus_init(memory, size, &setup) : NULL;
    if (self->bus == NULL) {
        return lx_fail(error, "no memory for a ring of %zu devices", self->count);
    }
    self->is = dg_ring_state(self->bus);
    return 0;
}

static int switch_on(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                     struct lx_error *error)
{
    for (size_t i = 0; i < setup->count; i++) {
        struct dg_host *encoder = self->encoders[i];
        const struct dg_nvm nvm = lx_ring_nvm(self, i);
        if ((nvm.ops != NULL && dg_host_memory_port(encoder, &nvm) != DG_HOST_OK) ||
            dg_host_power(encoder, now, true) != DG_HOST_OK) {
            return lx_fail(error, "device %zu does not start: not its EEPROM", i);
        }
        (void)dg_bus_attach(self->bus, encoder, setup->members[i].control);
    }
    return 0;
}

int lx_ring_open(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                 struct lx_error *error)
{
    memset(self, 0, sizeof *self);
    self->tap = setup->tap;
    if (make_encoders(self, setup, error) != 0) {
        return -1;
    }
    share_out(self, setup);
    return open_stores(self, setup, error) != 0 || make_ring(self, error) != 0
               ? -1
               : switch_on(self, setup, now, error);
}

void lx_ring_close(struct lx_ring *self)
{
    for (size_t i = 0; i < self->store_count; i++) {
        lx_image_close(&self->stores[i].image);
    }
    for (size_t i = 0; i < self->count; i++) {
        free(self->encoders[i]);
    }
    free(self->bus);
    free(self->stores);
    free(self->parts);
    free(self->part_of);
    free(self->encoders);
    memset(self, 0, sizeof *self);
}

bool lx_ring_cycle(struct lx_ring *self, dg_ns now)
{
    const struct dg_tap_event event = {
        .at = now,
        .kind = DG_TAP_WORDS,
        .words = {.out = self->out, .count = self->is->words, .identify = self->stopped},
    };
    dg_bus_watch(self->bus, self->tap != NULL && lx_tap_on(self->tap));
    (void)dg_bus_rx(self->bus, &event);
    return !self->is->dropped;
}
