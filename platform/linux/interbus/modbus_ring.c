/* SPDX-License-Identifier: MIT */
/*
 * Each K3 has its image in a slice of a memory (a file), which several may share. A file that does
 * not fit is found before anything is written: mounting a foreign image changes nothing.
 */
#include "modbus_ring.h"

#include <stdlib.h>
#include <string.h>

static int slice_read(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct lx_ring_slice *self = ctx;
    return self->whole.ops->read(self->whole.ctx, self->base + address, to, n);
}

static int slice_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    const struct lx_ring_slice *self = ctx;
    return self->whole.ops->write(self->whole.ctx, self->base + address, from, n);
}

static int slice_sync(void *ctx)
{
    struct lx_ring_slice *self = ctx;
    const int result =
        self->whole.ops->sync == NULL ? DG_OK : self->whole.ops->sync(self->whole.ctx);
    self->ticket = self->store->queue.issued;
    self->open = true;
    return result;
}

static const struct dg_nvm_ops slice_ops = {
    .read = slice_read, .write = slice_write, .sync = slice_sync};

struct dg_nvm lx_ring_nvm(const struct lx_ring *self, size_t index)
{
    return (struct dg_nvm){&slice_ops, &self->slices[index]};
}

const struct lx_nvm_queue *lx_ring_queue(const struct lx_ring *self, size_t index)
{
    const struct lx_ring_store *store = self->slices[index].store;
    return store->path == NULL ? NULL : &store->queue;
}

/* The memory with this file, a new one if there is none yet; NULL: the one without a file. */
static struct lx_ring_store *store_of(struct lx_ring *self, const char *path)
{
    for (size_t i = 0; i < self->store_count; i++) {
        const char *other = self->stores[i].path;
        if (path == other || (path != NULL && other != NULL && strcmp(path, other) == 0)) {
            return &self->stores[i];
        }
    }
    struct lx_ring_store *store = &self->stores[self->store_count++];
    *store = (struct lx_ring_store){.path = path, .file = {.fd = -1}};
    return store;
}

static int make_arrays(struct lx_ring *self, size_t count, struct lx_error *error)
{
    self->devices = calloc(count, sizeof *self->devices);
    self->models = calloc(count, sizeof *self->models);
    self->slices = calloc(count, sizeof *self->slices);
    self->stores = calloc(count, sizeof *self->stores);
    if (self->devices == NULL || self->models == NULL || self->slices == NULL ||
        self->stores == NULL) {
        return lx_fail(error, "no memory for %lu devices", (unsigned long)count);
    }
    return 0;
}

/* Which part of which memory is whose. */
static int share_out(struct lx_ring *self, const struct lx_ring_setup *setup,
                     struct lx_error *error)
{
    const uint32_t image = dg_store_size(&dg_ib_layout);
    if (make_arrays(self, setup->count, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < setup->count; i++) {
        struct lx_ring_store *store = store_of(self, setup->members[i].nvm);
        self->models[i] = setup->members[i].model;
        self->slices[i] = (struct lx_ring_slice){.store = store, .base = store->memory.size};
        store->memory.size += self->models[i].profile == DG_IB_K3 ? image : 0u;
    }
    for (size_t i = 0; i < self->store_count; i++) {
        struct lx_ring_store *store = &self->stores[i];
        if (store->memory.size == 0 && store->path != NULL) {
            (void)lx_refuse(error, "leave it out, or have a K3", "K1 and K2 have no EEPROM");
            return lx_about(error, LX_ABOUT_KEY, "nvm", store->path);
        }
        if (lx_nvm_memory_init(&store->memory, store->memory.size) != 0) {
            return lx_fail(error, "no memory for %lu devices", (unsigned long)setup->count);
        }
    }
    return 0;
}

/* The delivery state of all devices, in memory. */
static int deliver(struct lx_ring *self, size_t count, struct lx_error *error)
{
    for (size_t i = 0; i < count; i++) {
        self->slices[i].whole = lx_nvm_memory_port(&self->slices[i].store->memory);
        if (dg_ib_format(&self->models[i], lx_ring_nvm(self, i)) != DG_OK) {
            return lx_fail(error,
                           "device %lu: these factory figures make no encoder; a K1 has at "
                           "most 65536 steps, one with steps_minus_one at least 2",
                           (unsigned long)i);
        }
    }
    return 0;
}

/* The images of an earlier release are shorter and stand closer together. @return their size */
static size_t spread(struct lx_ring_store *self)
{
    const size_t image = dg_store_size(&dg_ib_layout);
    uint8_t *bytes = self->memory.bytes;
    struct dg_store store;
    if (dg_store_mount(&store, &dg_ib_layout, lx_nvm_memory_port(&self->memory)) != DG_ERR_OLDER) {
        return image;
    }
    const size_t older = dg_store_address(&dg_ib_layout, store.region_count);
    for (size_t i = self->memory.size / image; i-- > 0;) {
        memmove(bytes + i * image, bytes + i * older, older);
        memset(bytes + i * image + older, 0xFF, image - older);
    }
    return older;
}

/* What is in the file goes to `memory`, which is for looking at only from here on. */
static int open_file(struct lx_ring_store *self, const struct lx_say *say, struct lx_error *error)
{
    const struct lx_nvm_image delivery = {self->memory.bytes, self->memory.size,
                                          "the encoder answers 86000000h"};
    if (self->path == NULL) {
        return 0;
    }
    if (lx_nvm_file_open(&self->file, self->path, &delivery, error) != 0) {
        return -1;
    }
    const struct dg_nvm file = lx_nvm_file_port(&self->file);
    if (file.ops->read(file.ctx, 0, self->memory.bytes, self->memory.size) != DG_OK) {
        return lx_fail(error, "%s: cannot read", self->path);
    }
    const size_t image = dg_store_size(&dg_ib_layout);
    const size_t found = spread(self);
    self->older = found < image;
    lx_nvm_file_tell(&self->file, (uint32_t)(self->memory.size / image * found), say);
    return 0;
}

static int open_files(struct lx_ring *self, const struct lx_say *say, struct lx_error *error)
{
    for (size_t i = 0; i < self->store_count; i++) {
        if (open_file(&self->stores[i], say, error) != 0) {
            return -1;
        }
    }
    return 0;
}

/* As device `index` will mount it. */
static int mount(struct lx_ring *self, size_t index)
{
    struct dg_store store;
    const int result = dg_store_mount(&store, &dg_ib_layout, lx_ring_nvm(self, index));
    return result == DG_ERR_OLDER ? dg_store_grow(&store, &self->models[index]) : result;
}

/* Every image is looked at before the first file changes, and before the first device may repair
   its own. */
static int check_files(struct lx_ring *self, size_t count, struct lx_error *error)
{
    for (size_t i = 0; i < count; i++) {
        if (self->slices[i].store->path != NULL && self->models[i].profile == DG_IB_K3 &&
            mount(self, i) != DG_OK) {
            return lx_fail(error,
                           "%s: holds no image of device %lu; give a file made by this ring, or "
                           "the name of a new one",
                           self->slices[i].store->path, (unsigned long)i);
        }
    }
    for (size_t i = 0; i < self->store_count; i++) {
        struct lx_ring_store *store = &self->stores[i];
        if (store->older && lx_nvm_file_replace(&store->file, store->memory.bytes, error) != 0) {
            return -1;
        }
    }
    return 0;
}

/* The devices work on the files from here on. */
static int open_queues(struct lx_ring *self, const struct lx_ring_setup *setup,
                       struct lx_error *error)
{
    for (size_t i = 0; i < self->store_count; i++) {
        struct lx_ring_store *store = &self->stores[i];
        const struct lx_nvm_queue_setup queue = {
            .writer = setup->writer,
            .below = lx_nvm_file_port(&store->file),
            .size = store->memory.size,
            .settled = setup->settled,
            .ctx = setup->ctx,
        };
        if (store->path != NULL &&
            lx_nvm_queue_open(&store->queue, &queue, &store->nvm, error) != 0) {
            return -1;
        }
    }
    for (size_t i = 0; i < setup->count; i++) {
        if (self->slices[i].store->path != NULL) {
            self->slices[i].whole = self->slices[i].store->nvm;
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
    if (share_out(self, setup, error) != 0 || deliver(self, setup->count, error) != 0 ||
        open_files(self, setup->say, error) != 0 || check_files(self, setup->count, error) != 0 ||
        open_queues(self, setup, error) != 0 || switch_on(self, setup, now, error) != 0) {
        return -1;
    }
    return 0;
}

void lx_ring_close(struct lx_ring *self)
{
    for (size_t i = 0; i < self->store_count; i++) {
        lx_nvm_queue_close(&self->stores[i].queue);
        lx_nvm_file_close(&self->stores[i].file);
        lx_nvm_memory_free(&self->stores[i].memory);
    }
    free(self->stores);
    free(self->slices);
    free(self->models);
    free(self->devices);
    memset(self, 0, sizeof *self);
}

/* A device stores, and answers, within one cycle: what the master sees instead is from the one
   before. What a device stores by itself, without a command, holds up nothing. What is lost is not
   answered: the old words stay until there is another command. */
static void hold_back(struct lx_ring_slice *self, uint16_t *in, const uint16_t *before,
                      const uint16_t *out)
{
    static const uint16_t nothing[LX_RING_OWN_WORDS_MAX];
    const enum lx_nvm_state state = lx_nvm_queue_state(&self->store->queue, self->ticket);
    const bool same = memcmp(self->command, out, sizeof self->command) == 0;
    if (state == LX_NVM_THROUGH || (state == LX_NVM_LOST && !(self->holds && same))) {
        self->open = false;
        self->holds = false;
        return;
    }
    if (!self->holds && memcmp(out, nothing, sizeof nothing) != 0) {
        self->holds = true;
        memcpy(self->shown, before, sizeof self->shown);
        memcpy(self->command, out, sizeof self->command);
    }
    if (self->holds) {
        memcpy(in, self->shown, sizeof self->shown);
    }
}

static void hold_back_all(struct lx_ring *self)
{
    size_t at = 0;
    for (size_t i = 0; i < self->ring.count; i++) {
        if (self->slices[i].open) {
            hold_back(&self->slices[i], &self->in[at], &self->before[at], &self->out[at]);
        }
        at += dg_ib_words(&self->models[i]);
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
