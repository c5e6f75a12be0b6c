/* SPDX-License-Identifier: MIT */
#include "row_memory.h"

#include <string.h>

static bool refuses(const struct cf_memory *self, uint32_t address, size_t n)
{
    return self->silent || address > self->size || n > self->size - address;
}

static int read_bytes(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct cf_memory *self = ctx;

    if (refuses(self, address, n)) {
        return DG_ERR_IO;
    }
    memcpy(to, self->bytes + address, n);
    return DG_OK;
}

static int write_bytes(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct cf_memory *self = ctx;

    if (refuses(self, address, n)) {
        return DG_ERR_IO;
    }
    memcpy(self->bytes + address, from, n);
    return DG_OK;
}

static int sync_bytes(void *ctx)
{
    const struct cf_memory *self = ctx;

    return self->silent ? DG_ERR_IO : DG_OK;
}

void cf_memory_init(struct cf_memory *self, uint32_t size)
{
    memset(self, 0, sizeof *self);
    memset(self->bytes, 0xFF, sizeof self->bytes);
    self->size = size < CF_MEMORY_MAX ? size : CF_MEMORY_MAX;
}

struct dg_nvm cf_memory_port(struct cf_memory *self)
{
    static const struct dg_nvm_ops ops = {
        .read = read_bytes, .write = write_bytes, .sync = sync_bytes};

    return (struct dg_nvm){.ops = &ops, .ctx = self};
}
