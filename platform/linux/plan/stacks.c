/* SPDX-License-Identifier: MIT */
#include "stacks.h"

#include <string.h>

#include "drehgeber/rig_engine.h"

const struct lx_stack *lx_stack_of(const struct dg_device *device)
{
    size_t i = 0;
    while (lx_stacks[i]->core != device->stack) {
        i++; /* each has a row; a test looks */
    }
    return lx_stacks[i];
}

static const struct dg_key *address_row(const struct lx_stack *self)
{
    const char *key = self->core->address_key;
    return key == NULL ? NULL : dg_keys_find(self->handle->keys, key);
}

/* Bit n of a row n; 0: there is no such row. */
static uint32_t bit_of(const struct lx_stack *self, const struct dg_key *row)
{
    return row == NULL ? 0 : UINT32_C(1) << (row - self->handle->keys->rows);
}

/* What is not for --set. */
static uint32_t unsettable_keys_of(const struct lx_stack *self)
{
    return bit_of(self, dg_keys_find(self->handle->keys, "serial")) |
           bit_of(self, address_row(self));
}

void lx_stack_keys(const struct lx_stack *self, const struct dg_device *device,
                   const void *settings, const struct dg_world *world,
                   struct lx_keys lists[LX_STACK_LISTS])
{
    const bool all = device == NULL || self->without == NULL;
    const struct dg_keys *end = &dg_engine_end_keys[self->core->medium];
    lists[LX_STACK_END] =
        (struct lx_keys){.rows = end->rows, .count = end->count, .base = &dg_engine_end_usual};
    lists[LX_STACK_OWN] =
        (struct lx_keys){.rows = self->own.rows, .count = self->own.count, .base = self->usual};
    lists[LX_STACK_CORE] = (struct lx_keys){
        .rows = self->handle->keys->rows,
        .count = self->handle->keys->count,
        .base = settings,
        .without = unsettable_keys_of(self) | (all ? 0 : self->without(device)),
        .instead = self->instead,
    };
    lists[LX_STACK_WORLD] = (struct lx_keys){
        .rows = dg_world_keys.rows,
        .count = dg_world_keys.count,
        .base = world,
        .without = self->handle->blind,
    };
}

void lx_stack_deliver(const struct lx_stack *self, const struct dg_device *device, void *settings)
{
    const struct dg_host_wire *handle = self->handle;
    if (handle->furnish != NULL) {
        handle->furnish(settings, device);
    } else {
        memcpy(settings, device->model, handle->settings_size);
    }
}

/* --- names --- */

void lx_stack_models(const struct lx_stack *self, struct lx_words *to)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        if (self == NULL || lx_stack_of(dg_devices[i]) == self) {
            lx_words_add(to, " %s", dg_devices[i]->name);
        }
    }
}
