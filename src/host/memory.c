/* SPDX-License-Identifier: MIT */
/*
 * The image of an EEPROM, in and out: apart, so that who does neither does not link this.
 */
#include "host_private.h"

#include <string.h>

/* The size is that of the layout, without what rounds it up. */
size_t dg_host_memory_size(const struct dg_host *self)
{
    const struct dg_store_layout *layout =
        self->refs.device->stack->layout(self->refs.device->model);

    return layout != NULL ? dg_store_size(layout) : 0;
}

/* The EEPROM is in the handle. */
static bool has_memory(const struct dg_host *self)
{
    return self->refs.nvm.ops == NULL && self->memory_size >= dg_host_memory_size(self);
}

int dg_host_memory_copy(const struct dg_host *self, void *to, size_t n)
{
    const size_t size = dg_host_memory_size(self);

    if (!has_memory(self)) {
        return DG_HOST_ERR_STATE;
    }
    if (n < size) {
        return DG_HOST_ERR_SPACE;
    }
    if (size != 0) {
        memcpy(to, self->refs.memory, size);
    }
    return DG_HOST_OK;
}

int dg_host_memory_load(struct dg_host *self, const void *from, size_t n)
{
    if (!has_memory(self) || dg_host_powered(self)) {
        return DG_HOST_ERR_STATE;
    }
    if (n != dg_host_memory_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    if (n != 0) {
        memcpy(self->refs.memory, from, n);
    }
    self->loaded = true;
    return DG_HOST_OK;
}

int dg_host_memory_port(struct dg_host *self, const struct dg_nvm *nvm)
{
    if (self->made || nvm == NULL || nvm->ops == NULL) {
        return self->made ? DG_HOST_ERR_STATE : DG_HOST_ERR_ARGUMENT;
    }
    self->refs.nvm = *nvm;
    return DG_HOST_OK;
}
