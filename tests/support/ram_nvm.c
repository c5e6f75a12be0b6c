/* SPDX-License-Identifier: MIT */
/*
 * `bytes` is what a read sees, `synced` what is left when unsynced writes are lost. While a cut
 * with RAM_NVM_REORDERED is armed, every odd write call since ram_nvm_init() goes to `synced` at
 * once: it is one of those that overtook the others.
 */
#include "ram_nvm.h"

#include <assert.h>
#include <string.h>

#include "drehgeber/hal.h"

static bool refuses(const struct ram_nvm *self, uint32_t address, size_t n)
{
    return self->dead || self->no_acknowledge || address > self->size || n > self->size - address;
}

static int ram_read(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct ram_nvm *self = ctx;
    if (refuses(self, address, n)) {
        return DG_ERR_IO;
    }
    memcpy(to, self->bytes + address, n);
    return DG_OK;
}

/* A fixed noise that differs from write to write. */
static void garble(struct ram_nvm *self, uint32_t address, size_t n)
{
    uint32_t noise = self->writes * 2654435761u + address;
    for (size_t i = 0; i < n; i++) {
        noise = noise * 1664525u + 1013904223u;
        self->bytes[address + i] = (uint8_t)(noise >> 24);
    }
}

static void fail_power(struct ram_nvm *self, uint32_t address, const void *from, size_t n)
{
    const size_t through = self->tear_at < n ? self->tear_at : n;
    const bool odd = self->writes % 2 != 0;
    self->dead = true;
    if (self->tear == RAM_NVM_UNSYNCED || self->tear == RAM_NVM_REORDERED) {
        memcpy(self->bytes, self->synced, self->size);
    }
    if (self->tear == RAM_NVM_UNSYNCED || (self->tear == RAM_NVM_REORDERED && !odd)) {
        return;
    }
    memcpy(self->bytes + address, from, through);
    if (self->tear == RAM_NVM_GARBLED) {
        garble(self, address + (uint32_t)through, n - through);
    }
}

static int ram_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct ram_nvm *self = ctx;
    const bool armed = self->cut_at_write >= 0;
    const bool due = armed && self->writes >= self->cut_at_write;
    self->writes++;
    if (refuses(self, address, n)) {
        return DG_ERR_IO;
    }
    if (due) {
        fail_power(self, address, from, n);
        return DG_ERR_IO;
    }
    memcpy(self->bytes + address, from, n);
    if (armed && self->tear == RAM_NVM_REORDERED && self->writes % 2 != 0) {
        memcpy(self->synced + address, from, n);
    }
    return DG_OK;
}

static int ram_sync(void *ctx)
{
    struct ram_nvm *self = ctx;
    self->syncs++;
    if (refuses(self, 0, 0)) {
        return DG_ERR_IO;
    }
    memcpy(self->synced, self->bytes, self->size);
    return DG_OK;
}

void ram_nvm_init(struct ram_nvm *self, uint32_t size)
{
    assert(size <= RAM_NVM_MAX);
    memset(self, 0, sizeof *self);
    memset(self->bytes, 0xFF, sizeof self->bytes);
    memset(self->synced, 0xFF, sizeof self->synced);
    self->size = size;
    self->cut_at_write = -1;
}

struct dg_nvm ram_nvm_port(struct ram_nvm *self)
{
    static const struct dg_nvm_ops ops = {.read = ram_read, .write = ram_write, .sync = ram_sync};
    return (struct dg_nvm){.ops = &ops, .ctx = self};
}

void ram_nvm_cut(struct ram_nvm *self, uint32_t nth, enum ram_nvm_tear tear, uint32_t tear_at)
{
    self->cut_at_write = (int64_t)self->writes + nth;
    self->tear = tear;
    self->tear_at = tear_at;
}

void ram_nvm_restore(struct ram_nvm *self)
{
    self->dead = false;
    self->cut_at_write = -1;
    memcpy(self->synced, self->bytes, self->size);
}
