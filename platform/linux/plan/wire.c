/* SPDX-License-Identifier: MIT */
#include "wire.h"

#include <string.h>

const struct lx_wire *lx_wire_find(const char *name, size_t n)
{
    for (size_t i = 0; i < lx_wire_count; i++) {
        if (strlen(lx_wires[i].name) == n && memcmp(lx_wires[i].name, name, n) == 0) {
            return &lx_wires[i];
        }
    }
    return NULL;
}

bool lx_wire_has(const struct lx_wire *self, const char *key)
{
    for (size_t i = 0; self->keys != NULL && self->keys[i] != NULL; i++) {
        if (strcmp(self->keys[i], key) == 0) {
            return true;
        }
    }
    return false;
}
