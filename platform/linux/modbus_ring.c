/* SPDX-License-Identifier: MIT */
/*
 * All devices share one memory (a file): each K3 has its image in a slice of it. A file that does
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
    const struct lx_ring_slice *self = ctx;
    return self->whole.ops->sync == NULL ? DG_OK : self->whole.ops->sync(self->whole.ctx);
}

static const struct dg_nvm_ops slice_ops = {
    .read = slice_read, .write = slice_write, .sync = slice_sync};

static struct dg_nvm port_of(struct lx_ring *self, size_t index)
{
    return (struct dg_nvm){&slice_ops, &self->slices[index]};
}

/* Arrays, and which part of the memory is whose. @return false without memory */
static bool share_out(struct lx_ring *self, const struct lx_ring_setup *setup)
{
    const uint32_t image = dg_store_size(&dg_ib_layout);
    self->devices = calloc(setup->count, sizeof *self->devices);
    self->models = calloc(setup->count, sizeof *self->models);
    self->slices = calloc(setup->count, sizeof *self->slices);
    if (self->devices == NULL || self->models == NULL || self->slices == NULL) {
        return false;
    }
    for (size_t i = 0; i < setup->count; i++) {
        self->models[i] = lx_ring_settings_model(setup->settings, setup->models[i], (uint32_t)i);
        self->slices[i].base = self->memory.size;
        self->memory.size += self->models[i].profile == DG_IB_K3 ? image : 0u;
    }
    return true;
}

static void point_slices(struct lx_ring *self, size_t count, struct dg_nvm whole)
{
    for (size_t i = 0; i < count; i++) {
        self->slices[i].whole = whole;
    }
}

/* The delivery state of all devices, in memory. */
static int deliver(struct lx_ring *self, const struct lx_ring_setup *setup, struct lx_error *error)
{
    if (!share_out(self, setup) || lx_nvm_memory_init(&self->memory, self->memory.size) != 0) {
        return lx_fail(error, "no memory for %lu devices", (unsigned long)setup->count);
    }
    if (self->memory.size == 0 && setup->nvm != NULL) {
        return lx_fail(error, "--nvm %s: K1 and K2 have no EEPROM; leave it out, or have a K3",
                       setup->nvm);
    }
    point_slices(self, setup->count, lx_nvm_memory_port(&self->memory));
    for (size_t i = 0; i < setup->count; i++) {
        if (dg_ib_format(&self->models[i], port_of(self, i)) != DG_OK) {
            return lx_fail(error,
                           "device %lu: these factory figures make no encoder; a K1 has at "
                           "most 65536 steps, one with steps_minus_one at least 2",
                           (unsigned long)i);
        }
    }
    return 0;
}

static int open_file(struct lx_ring *self, const struct lx_ring_setup *setup,
                     struct lx_error *error)
{
    const struct lx_nvm_image delivery = {self->memory.bytes, self->memory.size};
    if (setup->nvm == NULL) {
        return 0;
    }
    if (lx_nvm_file_open(&self->file, setup->nvm, &delivery, error) != 0) {
        return -1;
    }
    if (self->file.length < self->file.size) {
        lx_note(setup->say, "%s: cut off, %lu of %lu bytes; what is missing reads FFh", setup->nvm,
                (unsigned long)self->file.length, (unsigned long)self->file.size);
    }
    point_slices(self, setup->count, lx_nvm_file_port(&self->file));
    return 0;
}

/* Every image is looked at before the first device may repair its own. */
static int check_file(struct lx_ring *self, const struct lx_ring_setup *setup,
                      struct lx_error *error)
{
    struct dg_nvm file = lx_nvm_file_port(&self->file);
    const struct dg_nvm copy = lx_nvm_memory_port(&self->memory);
    if (setup->nvm == NULL) {
        return 0;
    }
    if (file.ops->read(file.ctx, 0, self->memory.bytes, self->memory.size) != DG_OK) {
        return lx_fail(error, "%s: cannot read", setup->nvm);
    }
    for (size_t i = 0; i < setup->count; i++) {
        struct lx_ring_slice slice = {copy, self->slices[i].base};
        const struct dg_nvm port = {&slice_ops, &slice};
        struct dg_store store;
        if (self->models[i].profile == DG_IB_K3 &&
            dg_store_mount(&store, &dg_ib_layout, port) != DG_OK) {
            return lx_fail(error,
                           "%s: holds no image of device %lu; give a file made by this ring, or "
                           "the name of a new one",
                           setup->nvm, (unsigned long)i);
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
            .world = &setup->settings->common.world,
            .nvm = port_of(self, i),
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
    if (setup->settings->break_at != LX_AS_MODEL) {
        self->ring.broken_at = (uint16_t)setup->settings->break_at;
    }
    self->result = DG_IB_RING_IDENTIFY;
    return 0;
}

int lx_ring_open(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                 struct lx_error *error)
{
    memset(self, 0, sizeof *self);
    self->file.fd = -1;
    if (deliver(self, setup, error) != 0 || open_file(self, setup, error) != 0 ||
        check_file(self, setup, error) != 0 || switch_on(self, setup, now, error) != 0) {
        return -1;
    }
    return 0;
}

void lx_ring_close(struct lx_ring *self)
{
    lx_nvm_file_close(&self->file);
    lx_nvm_memory_free(&self->memory);
    free(self->slices);
    free(self->models);
    free(self->devices);
}

void lx_ring_cycle(struct lx_ring *self, dg_ns now)
{
    if (self->stopped) {
        self->reached = dg_ib_ring_id(&self->ring, now, self->ids);
        return;
    }
    self->result = dg_ib_ring_cycle(&self->ring, now, self->out, self->in);
    if (self->result == DG_IB_RING_INTERRUPTED || self->result == DG_IB_RING_IDENTIFY) {
        self->reached = dg_ib_ring_id(&self->ring, now, self->ids);
    }
}
