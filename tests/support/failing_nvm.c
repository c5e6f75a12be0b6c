/* SPDX-License-Identifier: MIT */
#include "failing_nvm.h"

#include <stdbool.h>

static bool fails(struct failing_nvm *self)
{
    return self->count++ == self->fails_at;
}

static int read_bytes(void *ctx, uint32_t address, void *to, size_t n)
{
    struct failing_nvm *self = ctx;

    return fails(self) ? DG_ERR_IO : self->behind.ops->read(self->behind.ctx, address, to, n);
}

static int write_bytes(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct failing_nvm *self = ctx;

    return fails(self) ? DG_ERR_IO : self->behind.ops->write(self->behind.ctx, address, from, n);
}

static int sync_bytes(void *ctx)
{
    struct failing_nvm *self = ctx;

    return fails(self) ? DG_ERR_IO : self->behind.ops->sync(self->behind.ctx);
}

struct dg_nvm failing_nvm_port(struct failing_nvm *self, struct dg_nvm behind, uint32_t fails_at)
{
    static const struct dg_nvm_ops ops = {read_bytes, write_bytes, sync_bytes};

    *self = (struct failing_nvm){behind, fails_at, 0};
    return (struct dg_nvm){&ops, self};
}
