/* SPDX-License-Identifier: MIT */
/*
 * A handle from its memory to its power:
 *
 *   | struct dg_host | queues, unless it is on a bus | settings | device | EEPROM, or the host's |
 */
#include "host_private.h"

#include <string.h>

_Static_assert(_Alignof(struct dg_host) <= DG_HOST_ALIGN, "what host.h asks for is enough");
_Static_assert(_Alignof(max_align_t) <= DG_HOST_ALIGN, "also for devices, see stack.h");
_Static_assert(offsetof(struct dg_host, line) == 0, "from a line to its handle");

struct host_parts dg_host_parts_of(const struct dg_device *model, const struct dg_host_wire *wire)
{
    const struct dg_store_layout *layout = model->stack->layout(model->model);
    struct host_parts parts;

    parts.settings = HOST_QUEUES_AT + dg_host_round(sizeof(struct host_queues));
    parts.device = parts.settings + dg_host_round(wire->settings_size);
    parts.memory = parts.device + dg_host_round(model->stack->device_size + model->more);
    parts.end = parts.memory + (layout != NULL ? dg_host_round(dg_store_size(layout)) : 0);
    return parts;
}

size_t dg_host_size(const struct dg_device *model, const struct dg_host_wire *wire)
{
    if (model->stack != wire->stack) {
        return 0;
    }
    return dg_host_parts_of(model, wire).end;
}

static void place_parts(struct dg_host *self, const struct host_parts *parts)
{
    uint8_t *base = (uint8_t *)self;

    self->refs.queues = parts->settings != HOST_QUEUES_AT
                            ? (struct host_queues *)(void *)(base + HOST_QUEUES_AT)
                            : NULL;
    self->line.settings = base + parts->settings;
    self->line.device = base + parts->device;
    self->refs.memory = base + parts->memory;
    self->memory_size = (uint32_t)(parts->end - parts->memory);
}

struct dg_host *dg_host_init_parts(void *memory, size_t size, const struct dg_device *model,
                                   const struct dg_host_wire *wire, const struct host_parts *parts)
{
    struct dg_host *self = memory;

    if (memory == NULL || model->stack != wire->stack || size < parts->end ||
        (uintptr_t)memory % DG_HOST_ALIGN != 0) {
        return NULL;
    }
    memset(memory, 0, parts->end);
    place_parts(self, parts);
    self->refs.device = model;
    self->refs.wire = wire;
    self->deadline = DG_NEVER;
    dg_world_init(&self->world);
    self->world.angle = dg_host_own_angle;
    self->world.angle_ctx = self;
    if (wire->furnish != NULL) {
        wire->furnish(self->line.settings, model);
    } else {
        memcpy(self->line.settings, model->model, wire->settings_size);
    }
    return self;
}

struct dg_host *dg_host_init(void *memory, size_t size, const struct dg_device *model,
                             const struct dg_host_wire *wire)
{
    const struct host_parts parts = dg_host_parts_of(model, wire);

    return dg_host_init_parts(memory, size, model, wire, &parts);
}

const char *dg_host_model(const struct dg_host *self)
{
    return self->refs.device->name;
}

const char *dg_host_protocol(const struct dg_host *self)
{
    return self->refs.device->stack->name;
}

/* ------------------------------------------------------------ EEPROM */

static int check_memory_range(const struct dg_host *self, uint32_t address, size_t n)
{
    return address <= self->memory_size && n <= self->memory_size - address ? DG_OK : DG_ERR_IO;
}

static int read_own(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct dg_host *self = ctx;
    const int result = check_memory_range(self, address, n);

    if (result == DG_OK) {
        memcpy(to, self->refs.memory + address, n);
    }
    return result;
}

static int write_own(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct dg_host *self = ctx;
    const int result = check_memory_range(self, address, n);

    if (result == DG_OK) {
        memcpy(self->refs.memory + address, from, n);
    }
    return result;
}

static const struct dg_nvm_ops own_memory = {.read = read_own, .write = write_own};

struct dg_stack_setup dg_host_setup(struct dg_host *self)
{
    struct dg_stack_setup setup = {.model = self->refs.device->model,
                                   .world = &self->world,
                                   .nvm = self->refs.nvm,
                                   .ctx = &self->line};

    if (self->refs.nvm.ops == NULL && self->memory_size != 0) {
        setup.nvm = (struct dg_nvm){&own_memory, self};
    }
    if (self->refs.wire->arrange != NULL) {
        self->refs.wire->arrange(self->line.settings, &setup);
    }
    setup.model = self->line.settings;
    return setup;
}

/* ------------------------------------------------------------ power */

/* A memory of the host's may have an image from an earlier life. */
static int format_memory(struct dg_host *self, const struct dg_stack_setup *setup)
{
    const struct dg_stack *stack = self->refs.device->stack;
    const bool stores = stack->layout(setup->model) != NULL;
    struct dg_store store;

    if (stores && setup->nvm.ops == NULL) {
        return DG_ERR_IO; /* the host has not said where it is */
    }
    if (self->loaded) {
        return DG_OK;
    }
    if (stores && self->refs.nvm.ops != NULL) {
        const int result = stack->mount(setup, &store);
        return result == DG_ERR_BLANK ? stack->format(setup) : result;
    }
    return stack->format(setup);
}

static int make_handle(struct dg_host *self)
{
    const struct dg_stack_setup setup = dg_host_setup(self);
    const int result = format_memory(self, &setup);

    if (result != DG_OK) {
        return result;
    }
    return self->refs.device->stack->init(self->line.device, &setup);
}

int dg_host_power(struct dg_host *self, uint64_t now, bool on)
{
    const struct dg_stack *stack = self->refs.device->stack;
    int result = DG_OK;

    dg_host_run(self, now);
    if (!self->made && on) {
        result = make_handle(self);
        self->made = result == DG_OK;
    }
    if (!self->made) {
        return result;
    }
    self->line.until = 0;
    if (on) {
        result = stack->power_on(self->line.device, self->line.now);
        if (self->refs.faults != NULL) {
            self->refs.faults->feel(self->refs.faults_ctx);
        }
    } else {
        stack->power_off(self->line.device);
    }
    if (!self->line.on_bus) {
        dg_host_run(self, now);
    }
    return result;
}

bool dg_host_powered(const struct dg_host *self)
{
    return self->made && self->refs.device->stack->powered(self->line.device);
}

/* ------------------------------------------------------------ looks */

int dg_host_position(const struct dg_host *self, uint64_t at, uint64_t *counts)
{
    if (!dg_host_powered(self)) {
        return DG_HOST_ERR_STATE;
    }
    *counts = self->refs.device->stack->position(self->line.device, at);
    return DG_HOST_OK;
}

int dg_host_positions(const struct dg_host *self, uint64_t at, uint64_t interval, uint64_t *counts,
                      size_t n)
{
    int result = dg_host_powered(self) ? DG_HOST_OK : DG_HOST_ERR_STATE;

    for (size_t i = 0; i < n && result == DG_HOST_OK; i++) {
        result = dg_host_position(self, at + i * interval, &counts[i]);
    }
    return result;
}

const void *dg_host_device(const struct dg_host *self, const struct dg_host_wire *wire, int *result)
{
    if (self->refs.wire != wire) {
        *result = DG_HOST_ERR_WIRE;
        return NULL;
    }
    *result = dg_host_powered(self) ? DG_HOST_OK : DG_HOST_ERR_STATE;
    return *result == DG_HOST_OK ? self->line.device : NULL;
}
