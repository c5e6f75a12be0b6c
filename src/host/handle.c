/* SPDX-License-Identifier: MIT */
/*
 * A handle from its memory to its power:
 *
 *   | struct dg_host | settings | device | EEPROM |
 */
#include "host_private.h"

#include <string.h>

_Static_assert(_Alignof(struct dg_host) <= DG_HOST_ALIGN, "what host.h asks for is enough");
_Static_assert(_Alignof(max_align_t) <= DG_HOST_ALIGN, "also for devices, see stack.h");
_Static_assert(offsetof(struct dg_host, line) == 0, "from a line to its handle");

size_t dg_host_round(size_t n)
{
    return (n + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN;
}

struct host_parts dg_host_parts_of(const struct dg_device *model, const struct dg_host_wire *wire)
{
    const struct dg_store_layout *layout = model->stack->layout(model->model);

    return (struct host_parts){
        .settings = dg_host_round(wire->settings_size),
        .device = dg_host_round(model->stack->device_size),
        .memory = layout != NULL ? dg_host_round(dg_store_size(layout)) : 0,
    };
}

size_t dg_host_size(const struct dg_device *model, const struct dg_host_wire *wire)
{
    if (model->stack != wire->stack) {
        return 0;
    }
    const struct host_parts parts = dg_host_parts_of(model, wire);
    return dg_host_round(sizeof(struct dg_host)) + parts.settings + parts.device + parts.memory;
}

struct dg_host *dg_host_init(void *memory, size_t size, const struct dg_device *model,
                             const struct dg_host_wire *wire)
{
    const size_t needed = dg_host_size(model, wire);
    struct dg_host *self = memory;
    uint8_t *behind = memory;

    if (memory == NULL || needed == 0 || size < needed || (uintptr_t)memory % DG_HOST_ALIGN != 0) {
        return NULL;
    }
    const struct host_parts parts = dg_host_parts_of(model, wire);
    memset(memory, 0, needed);
    behind += dg_host_round(sizeof *self);
    self->line.settings = behind;
    self->line.device = behind + parts.settings;
    self->memory = behind + parts.settings + parts.device;
    self->memory_size = (uint32_t)parts.memory;
    self->device = model;
    self->wire = wire;
    self->deadline = DG_NEVER;
    dg_world_init(&self->world);
    self->world.angle = dg_host_sense_angle;
    self->world.angle_ctx = self;
    if (wire->furnish != NULL) {
        wire->furnish(self->line.settings, model);
    } else {
        memcpy(self->line.settings, model->model, wire->settings_size);
    }
    return self;
}

const char *dg_host_model(const struct dg_host *self)
{
    return self->device->name;
}

const char *dg_host_protocol(const struct dg_host *self)
{
    return self->device->stack->name;
}

/* ------------------------------------------------------------ EEPROM */

static int reach(const struct dg_host *self, uint32_t address, size_t n)
{
    return address <= self->memory_size && n <= self->memory_size - address ? DG_OK : DG_ERR_IO;
}

static int read_own(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct dg_host *self = ctx;
    const int result = reach(self, address, n);

    if (result == DG_OK) {
        memcpy(to, self->memory + address, n);
    }
    return result;
}

static int write_own(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct dg_host *self = ctx;
    const int result = reach(self, address, n);

    if (result == DG_OK) {
        memcpy(self->memory + address, from, n);
    }
    return result;
}

static const struct dg_nvm_ops own_memory = {.read = read_own, .write = write_own};

struct dg_stack_setup dg_host_setup(struct dg_host *self)
{
    struct dg_stack_setup setup = {
        .model = self->line.settings, .world = &self->world, .nvm = self->nvm, .ctx = &self->line};

    if (self->nvm.ops == NULL && self->memory_size != 0) {
        setup.nvm = (struct dg_nvm){&own_memory, self};
    }
    if (self->wire->arrange != NULL) {
        self->wire->arrange(self->line.settings, &setup);
    }
    return setup;
}

/* The size is that of the layout, without what rounds it up. */
size_t dg_host_memory_size(const struct dg_host *self)
{
    const struct dg_store_layout *layout = self->device->stack->layout(self->device->model);

    return layout != NULL ? dg_store_size(layout) : 0;
}

int dg_host_memory_copy(const struct dg_host *self, void *to, size_t n)
{
    const size_t size = dg_host_memory_size(self);

    if (self->nvm.ops != NULL) {
        return DG_HOST_ERR_STATE;
    }
    if (n < size) {
        return DG_HOST_ERR_SPACE;
    }
    if (size != 0) {
        memcpy(to, self->memory, size);
    }
    return DG_HOST_OK;
}

int dg_host_memory_load(struct dg_host *self, const void *from, size_t n)
{
    if (self->nvm.ops != NULL || dg_host_powered(self)) {
        return DG_HOST_ERR_STATE;
    }
    if (n != dg_host_memory_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    if (n != 0) {
        memcpy(self->memory, from, n);
    }
    self->loaded = true;
    return DG_HOST_OK;
}

int dg_host_memory_port(struct dg_host *self, const struct dg_nvm *nvm)
{
    if (self->made || nvm == NULL || nvm->ops == NULL) {
        return self->made ? DG_HOST_ERR_STATE : DG_HOST_ERR_ARGUMENT;
    }
    self->nvm = *nvm;
    return DG_HOST_OK;
}

/* ------------------------------------------------------------ power */

/* A memory of the host's may have an image from an earlier life. */
static int format(struct dg_host *self, const struct dg_stack_setup *setup)
{
    const struct dg_stack *stack = self->device->stack;
    struct dg_store store;

    if (self->loaded) {
        return DG_OK;
    }
    if (self->nvm.ops != NULL && stack->layout(setup->model) != NULL) {
        const int result = stack->mount(setup, &store);
        return result == DG_ERR_BLANK ? stack->format(setup) : result;
    }
    return stack->format(setup);
}

static int make(struct dg_host *self)
{
    const struct dg_stack_setup setup = dg_host_setup(self);
    const int result = format(self, &setup);

    if (result != DG_OK) {
        return result;
    }
    return self->device->stack->init(self->line.device, &setup);
}

int dg_host_power(struct dg_host *self, uint64_t now, bool on)
{
    const struct dg_stack *stack = self->device->stack;
    int result = DG_OK;

    dg_host_run(self, now);
    if (!self->made && on) {
        result = make(self);
        self->made = result == DG_OK;
    }
    if (!self->made) {
        return result;
    }
    self->line.until = 0;
    if (on) {
        result = stack->power_on(self->line.device, self->line.now);
    } else {
        stack->power_off(self->line.device);
    }
    dg_host_run(self, now);
    return result;
}

bool dg_host_powered(const struct dg_host *self)
{
    return self->made && self->device->stack->powered(self->line.device);
}

/* ------------------------------------------------------------ looks */

int dg_host_position(const struct dg_host *self, uint64_t at, uint64_t *counts)
{
    if (!dg_host_powered(self)) {
        return DG_HOST_ERR_STATE;
    }
    *counts = self->device->stack->position(self->line.device, at);
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
    if (self->wire != wire) {
        *result = DG_HOST_ERR_WIRE;
        return NULL;
    }
    *result = dg_host_powered(self) ? DG_HOST_OK : DG_HOST_ERR_STATE;
    return *result == DG_HOST_OK ? self->line.device : NULL;
}
