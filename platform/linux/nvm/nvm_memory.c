/* SPDX-License-Identifier: MIT */
/* No sync: nothing here survives, so everything is as durable as it gets. */
#include "nvm_memory.h"

#include <stdlib.h>
#include <string.h>

static int read_memory(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct lx_nvm_memory *self = ctx;
    return lx_nvm_read(self->bytes, self->size, address, to, n);
}

static int write_memory(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct lx_nvm_memory *self = ctx;
    if (!lx_nvm_inside(self->size, address, n)) {
        return DG_ERR_IO;
    }
    memcpy(self->bytes + address, from, n);
    return DG_OK;
}

static const struct dg_nvm_ops memory_ops = {.read = read_memory, .write = write_memory};

int lx_nvm_memory_init(struct lx_nvm_memory *self, uint32_t size)
{
    self->bytes = malloc(size);
    self->size = size;
    if (self->bytes == NULL) {
        return -1;
    }
    memset(self->bytes, 0xFF, size); /* erased */
    return 0;
}

void lx_nvm_memory_free(struct lx_nvm_memory *self)
{
    free(self->bytes);
    self->bytes = NULL;
}

struct dg_nvm lx_nvm_memory_port(struct lx_nvm_memory *self)
{
    return (struct dg_nvm){&memory_ops, self};
}
