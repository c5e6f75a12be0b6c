/* SPDX-License-Identifier: MIT */
/*
 * A file is shared out in the order of the encoders, each part as long as its layout says. One of
 * an earlier release has shorter parts, which stand closer together:
 *
 *   file    |first|second|        found
 *   memory  |first  |second  |    base, size: moved apart, the rest FFh as in a cut-off file
 */
#include "image.h"

#include <string.h>

#include "drehgeber/devices.h"

/* --- parts --- */

static int part_read(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct lx_image_part *self = ctx;
    const struct dg_nvm *whole = &self->image->nvm;
    return whole->ops->read(whole->ctx, self->base + address, to, n);
}

static int part_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    const struct lx_image_part *self = ctx;
    const struct dg_nvm *whole = &self->image->nvm;
    return whole->ops->write(whole->ctx, self->base + address, from, n);
}

static int part_sync(void *ctx)
{
    struct lx_image_part *self = ctx;
    const struct dg_nvm *whole = &self->image->nvm;
    const int result = whole->ops->sync == NULL ? DG_OK : whole->ops->sync(whole->ctx);
    if (result == DG_OK) {
        self->ticket = self->image->queue.issued;
    }
    return result;
}

static const struct dg_nvm_ops part_ops = {
    .read = part_read, .write = part_write, .sync = part_sync};

static const struct dg_store_layout *layout_of(const struct lx_image_part *self)
{
    return self->stack->layout(self->device.model);
}

/* --- the delivery state --- */

static uint32_t place_parts(struct lx_image *self)
{
    uint32_t size = 0;
    for (size_t i = 0; i < self->setup.count; i++) {
        struct lx_image_part *part = &self->setup.parts[i];
        const struct dg_store_layout *layout = layout_of(part);
        part->image = self;
        part->base = size;
        part->size = layout == NULL ? 0 : dg_store_size(layout);
        part->found = part->size;
        part->device.nvm =
            layout == NULL ? (struct dg_nvm){NULL, NULL} : (struct dg_nvm){&part_ops, part};
        size += part->size;
    }
    return size;
}

/* It is not the file that is wrong. */
static int no_encoder(const struct lx_image_part *self, struct lx_error *error)
{
    (void)(self->right == NULL
               ? lx_fail(error, "these factory figures make no encoder")
               : lx_refuse(error, self->right, "device %lu: these factory figures make no encoder",
                           (unsigned long)self->place));
    return lx_about(error, LX_ABOUT_ITSELF, "", NULL);
}

static int deliver_parts(struct lx_image *self, struct lx_error *error)
{
    if (lx_nvm_memory_init(&self->memory, place_parts(self)) != 0) {
        return lx_fail(error, "no memory for the EEPROM");
    }
    self->nvm = lx_nvm_memory_port(&self->memory);
    for (size_t i = 0; i < self->setup.count; i++) {
        const struct lx_image_part *part = &self->setup.parts[i];
        if (part->stack->format(&part->device) != DG_OK) {
            return no_encoder(part, error);
        }
    }
    return 0;
}

/* --- a file that is there --- */

/* Bytes that a part has behind `at`. Mounting only repairs what is the part's. */
static uint32_t found_at(const struct lx_image_part *self, uint32_t at)
{
    struct lx_image_part probe = *self;
    struct dg_store store;
    probe.base = at;
    const int result = dg_store_mount(&store, layout_of(self), (struct dg_nvm){&part_ops, &probe});
    return result == DG_ERR_OLDER ? dg_store_address(store.layout, store.region_count) : self->size;
}

/* @return bytes of all parts in the file */
static uint32_t find_stored_parts(struct lx_image *self)
{
    uint32_t at = 0;
    for (size_t i = 0; i < self->setup.count; i++) {
        struct lx_image_part *part = &self->setup.parts[i];
        part->found = part->size == 0 ? 0 : found_at(part, at);
        at += part->found;
    }
    return at;
}

static void move_apart(struct lx_image *self, uint32_t end)
{
    uint8_t *bytes = self->memory.bytes;
    for (size_t i = self->setup.count; i-- > 0;) {
        const struct lx_image_part *part = &self->setup.parts[i];
        end -= part->found;
        memmove(bytes + part->base, bytes + end, part->found);
        memset(bytes + part->base + part->found, 0xFF, part->size - part->found);
    }
}

static int refuse_image(const struct lx_image_part *self, int mounted, struct lx_error *error)
{
    static const char right[] = "give a file made by drehgeber, or the name of a new one";
    const char *path = self->image->setup.path;
    return self->image->setup.count > 1
               ? lx_refuse(error, right, "%s: holds no image of device %lu", path,
                           (unsigned long)self->place)
               : lx_refuse(error, right, "%s: %s, no image of this kind of encoder", path,
                           mounted == DG_ERR_BLANK ? "blank" : "something else");
}

/* The model as ordered whose figures the memory has, for messages. */
static const char *owning_model_of(const struct lx_image_part *self, struct dg_store *store)
{
    struct dg_stack_setup other = self->device;
    for (size_t i = 0; i < dg_device_count; i++) {
        other.model = dg_devices[i]->model;
        if (dg_devices[i]->stack == self->stack && self->stack->differs(&other, store) == NULL) {
            return dg_devices[i]->name;
        }
    }
    return "an encoder with other factory figures";
}

static int check_stored_figures(const struct lx_image_part *self, struct dg_store *store,
                                struct lx_error *error)
{
    const struct dg_stack *stack = self->stack;
    const char *what = stack->differs == NULL ? NULL : stack->differs(&self->device, store);
    return what == NULL ? 0
                        : lx_refuse(error,
                                    "run that one with the same settings, or give the name of a "
                                    "new file",
                                    "%s: belongs to %s (%s differs)", self->image->setup.path,
                                    owning_model_of(self, store), what);
}

/* One that is damaged is the device's to report. */
static int check_serial(const struct lx_image_part *self, struct dg_store *store,
                        struct lx_error *error)
{
    const bool asked = self->serial_given && self->stack->serial != NULL;
    const int64_t serial = asked ? self->stack->serial(store) : -1;
    return serial < 0 || serial == (int64_t)self->device.serial
               ? 0
               : lx_refuse(error, "run that one, or give the name of a new file",
                           "%s: belongs to serial number %lld", self->image->setup.path,
                           (long long)serial);
}

/* What NVM:ERASe began is ended here, as if the file were new: there is nothing in it any more. */
static int finish_image(struct lx_image_part *self, struct lx_error *error)
{
    struct lx_image *image = self->image;
    lx_note(image->setup.say, "%s: NVM:ERASe was interrupted, and is completed now",
            image->setup.path);
    image->finished = true;
    return self->stack->format(&self->device) == DG_OK ? 0 : no_encoder(self, error);
}

/* As its encoder will mount it. */
static int check_part(struct lx_image_part *self, struct lx_error *error)
{
    struct dg_store store;
    const int mounted = self->stack->mount(&self->device, &store);
    /* NVM:ERASe leaves the length as it is; of a file that was cut off nobody knows what it had. */
    const bool whole = self->image->file.length >= self->image->memory.size;
    if (mounted == DG_ERR_BLANK && whole &&
        dg_store_unfinished(layout_of(self), self->device.nvm)) {
        return finish_image(self, error);
    }
    if (mounted != DG_OK) {
        return refuse_image(self, mounted, error);
    }
    return check_stored_figures(self, &store, error) != 0 ? -1 : check_serial(self, &store, error);
}

static int inspect_image(struct lx_image *self, struct lx_error *error)
{
    const struct dg_nvm file = lx_nvm_file_port(&self->file);
    if (file.ops->read(file.ctx, 0, self->memory.bytes, self->memory.size) != DG_OK) {
        return lx_fail(error, "%s: cannot read", self->setup.path);
    }
    const uint32_t found = find_stored_parts(self);
    move_apart(self, found);
    for (size_t i = 0; i < self->setup.count; i++) {
        struct lx_image_part *part = &self->setup.parts[i];
        if (part->size > 0 && check_part(part, error) != 0) {
            return -1;
        }
    }
    lx_nvm_file_tell(&self->file, found, self->setup.say);
    return 0;
}

/* --- open, close --- */

int lx_image_open(struct lx_image *self, const struct lx_image_setup *setup, struct lx_error *error)
{
    *self = (struct lx_image){.setup = *setup, .file = {.fd = -1}};
    if (deliver_parts(self, error) != 0) {
        return -1;
    }
    const struct lx_nvm_image delivery = {self->memory.bytes, self->memory.size, setup->answer};
    if (setup->path == NULL) {
        return 0;
    }
    if (lx_nvm_file_open(&self->file, setup->path, &delivery, error) != 0) {
        return -1;
    }
    return self->file.created ? 0 : inspect_image(self, error);
}

/* One encoder makes its own memory grow in place; the neighbours of several are in the way. */
static bool stands_closer(const struct lx_image *self)
{
    bool shorter = false;
    for (size_t i = 0; i < self->setup.count; i++) {
        shorter = shorter || self->setup.parts[i].found < self->setup.parts[i].size;
    }
    return shorter && self->setup.count > 1;
}

int lx_image_start(struct lx_image *self, struct lx_error *error)
{
    if (self->setup.path == NULL) {
        return 0;
    }
    if ((stands_closer(self) || self->finished) &&
        lx_nvm_file_replace(&self->file, self->memory.bytes, error) != 0) {
        return -1;
    }
    const struct lx_nvm_queue_setup queue = {
        .writer = self->setup.writer,
        .below = lx_nvm_file_port(&self->file),
        .size = self->memory.size,
        .path = self->setup.path,
        .settled = self->setup.settled,
        .ctx = self->setup.ctx,
    };
    return lx_nvm_queue_open(&self->queue, &queue, &self->nvm, error);
}

const struct lx_nvm_queue *lx_image_queue(const struct lx_image *self)
{
    return self->setup.path == NULL || self->setup.writer == NULL ? NULL : &self->queue;
}

void lx_image_close(struct lx_image *self)
{
    if (self->memory.bytes == NULL) {
        return;
    }
    lx_nvm_queue_close(&self->queue);
    if (lx_nvm_writer_on_trial(self->setup.writer)) {
        lx_nvm_file_unmake(&self->file);
    }
    lx_nvm_file_close(&self->file);
    lx_nvm_memory_free(&self->memory);
}
