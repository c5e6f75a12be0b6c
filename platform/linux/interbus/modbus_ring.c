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
    return self->windows[index].part->device.nvm;
}

const struct lx_nvm_queue *lx_ring_queue(const struct lx_ring *self, size_t index)
{
    return lx_image_queue(self->windows[index].part->image);
}

static int make_arrays(struct lx_ring *self, size_t count, struct lx_error *error)
{
    self->devices = calloc(count, sizeof *self->devices);
    self->models = calloc(count, sizeof *self->models);
    self->windows = calloc(count, sizeof *self->windows);
    self->parts = calloc(count, sizeof *self->parts);
    self->stores = calloc(count, sizeof *self->stores);
    if (self->devices == NULL || self->models == NULL || self->windows == NULL ||
        self->parts == NULL || self->stores == NULL) {
        return lx_fail(error, "no memory for %lu devices", (unsigned long)count);
    }
    return 0;
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
        self->windows[i].part = &parts[store->count++];
        *self->windows[i].part = (struct lx_image_part){
            .stack = &dg_ib_stack,
            .device = {.model = &self->models[i]},
            .place = i,
            .right = "a K1 has at most 65536 steps, one with steps_minus_one at least 2",
        };
    }
}

/* Which part of which memory is whose. */
static int share_out(struct lx_ring *self, const struct lx_ring_setup *setup,
                     struct lx_error *error)
{
    size_t used = 0;
    if (make_arrays(self, setup->count, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < setup->count; i++) {
        self->models[i] = setup->members[i].model;
    }
    for (size_t i = 0; i < setup->count; i++) {
        if (self->windows[i].part == NULL) {
            gather(self, setup, i, &self->parts[used]);
            used += self->stores[self->store_count - 1].count;
        }
    }
    return 0;
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
        .answer = "the encoder answers 86000000h",
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

static int switch_on(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                     struct lx_error *error)
{
    for (size_t i = 0; i < setup->count; i++) {
        const struct dg_ib_setup device = {
            .model = &self->models[i],
            .world = setup->members[i].world,
            .nvm = lx_ring_nvm(self, i),
        };
        if (dg_ib_init(&self->devices[i], &device) != DG_OK ||
            dg_ib_power_on(&self->devices[i], now) != DG_OK) {
            return lx_fail(error, "device %lu does not start: not its EEPROM", (unsigned long)i);
        }
    }
    if (dg_ib_ring_init(&self->ring, self->devices, setup->count) != DG_OK) {
        return lx_fail(error, "a ring has 1 to %u devices, not %lu", DG_IB_RING_MAX,
                       (unsigned long)setup->count);
    }
    self->result = DG_IB_RING_IDENTIFY;
    return 0;
}

int lx_ring_open(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                 struct lx_error *error)
{
    memset(self, 0, sizeof *self);
    return share_out(self, setup, error) != 0 || open_stores(self, setup, error) != 0
               ? -1
               : switch_on(self, setup, now, error);
}

void lx_ring_close(struct lx_ring *self)
{
    for (size_t i = 0; i < self->store_count; i++) {
        lx_image_close(&self->stores[i].image);
    }
    free(self->stores);
    free(self->parts);
    free(self->windows);
    free(self->models);
    free(self->devices);
    memset(self, 0, sizeof *self);
}

/* A device stores, and answers, within one cycle: what the master sees instead is from the one
   before. What a device stores by itself, without a command, holds up nothing. What is lost is not
   answered: the old words stay until there is another command. */
static void hold_back(struct lx_ring_window *self, uint16_t *in, const uint16_t *before,
                      const uint16_t *out)
{
    static const uint16_t nothing[LX_RING_OWN_WORDS_MAX];
    const uint64_t ticket = self->part->ticket;
    const enum lx_nvm_state state = lx_nvm_queue_state(&self->part->image->queue, ticket);
    const bool commanded = memcmp(out, nothing, sizeof nothing) != 0;
    if (state != LX_NVM_THROUGH && ticket != self->looked && commanded) {
        if (!self->holds) {
            memcpy(self->shown, before, sizeof self->shown);
        }
        self->holds = true;
        memcpy(self->command, out, sizeof self->command);
    }
    self->looked = ticket;
    const bool same = self->holds && memcmp(self->command, out, sizeof self->command) == 0;
    if (state == LX_NVM_THROUGH || (state == LX_NVM_LOST && !same)) {
        self->settled = ticket;
        self->holds = false;
    }
    if (self->holds) {
        memcpy(in, self->shown, sizeof self->shown);
    }
}

static void hold_back_all(struct lx_ring *self)
{
    size_t at = 0;
    for (size_t i = 0; i < self->ring.count; i++) {
        if (self->windows[i].part->ticket != self->windows[i].settled) {
            hold_back(&self->windows[i], &self->in[at], &self->before[at], &self->out[at]);
        }
        at += dg_ib_image_words(&self->models[i]);
    }
}

void lx_ring_cycle(struct lx_ring *self, dg_ns now)
{
    if (self->stopped) {
        self->reached = dg_ib_ring_id(&self->ring, now, self->ids);
        return;
    }
    memcpy(self->before, self->in, self->ring.words * sizeof self->in[0]);
    self->result = dg_ib_ring_cycle(&self->ring, now, self->out, self->in);
    hold_back_all(self);
    if (self->result == DG_IB_RING_INTERRUPTED || self->result == DG_IB_RING_IDENTIFY) {
        self->reached = dg_ib_ring_id(&self->ring, now, self->ids);
    }
}

dg_ns lx_ring_quiet(const struct lx_ring *self, dg_ns now)
{
    return self->stopped ? DG_NEVER : dg_ib_ring_quiet(&self->ring, self->result, now);
}

/* The counters wrap, as they do one by one. */
void lx_ring_skip(struct lx_ring *self, uint64_t n)
{
    if (!self->stopped) {
        dg_ib_ring_skip(&self->ring, self->result, (uint32_t)n);
    }
    if (self->stopped || self->result == DG_IB_RING_INTERRUPTED) {
        dg_ib_ring_skip_ids(&self->ring, (uint32_t)n);
    }
}
