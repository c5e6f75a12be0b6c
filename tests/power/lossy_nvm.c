/* SPDX-License-Identifier: MIT */
/*
 * The fate of a write of n bytes:
 *
 *   kept | lost | torn at byte k: the first k bytes there and the others as they were,
 *                                 or noise, or the other way round
 *
 * k is every boundary of a short write, and the outermost and the middle one of a longer one. Two
 * pending writes to the same bytes are also tried in the other order.
 */
#include "lossy_nvm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

/* --- operations --- */

static bool fails(struct lossy_nvm *self)
{
    const uint32_t call = self->calls++;
    return call >= self->die_at || (call >= self->fail_from && call < self->fail_to);
}

static bool outside(const struct lossy_nvm *self, uint32_t address, size_t n)
{
    return address > self->size || n > self->size - address;
}

static int lossy_read(void *ctx, uint32_t address, void *to, size_t n)
{
    struct lossy_nvm *self = ctx;
    if (fails(self) || outside(self, address, n)) {
        return DG_ERR_IO;
    }
    memcpy(to, self->bytes + address, n);
    return DG_OK;
}

static size_t part(enum lossy_nvm_through through, size_t n)
{
    return through == LOSSY_NVM_ALL ? n : through == LOSSY_NVM_HALF ? n / 2 : 0;
}

static int lossy_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct lossy_nvm *self = ctx;
    const bool dead = self->calls >= self->die_at;
    const bool failing = fails(self);
    const size_t through = dead ? 0 : failing ? part(self->through, n) : n;
    if (outside(self, address, n)) {
        return DG_ERR_IO;
    }
    if (through > 0) {
        assert_true(self->pending_count < LOSSY_NVM_PENDING);
        assert_true(through <= LOSSY_NVM_LOG - self->log_length);
        self->pending[self->pending_count++] =
            (struct lossy_nvm_write){address, self->log_length, (uint16_t)through};
        memcpy(self->log + self->log_length, from, through);
        memcpy(self->bytes + address, from, through);
        self->log_length += (uint32_t)through;
    }
    return failing ? DG_ERR_IO : DG_OK;
}

static int lossy_sync(void *ctx)
{
    struct lossy_nvm *self = ctx;
    if (fails(self)) {
        return DG_ERR_IO;
    }
    if (self->syncs++ == self->skip) {
        return DG_OK;
    }
    if (self->before_sync != NULL) {
        self->before_sync(self->ctx);
    }
    memcpy(self->durable, self->bytes, self->size);
    self->pending_count = 0;
    self->log_length = 0;
    return DG_OK;
}

void lossy_nvm_init(struct lossy_nvm *self, const uint8_t *image, uint32_t size)
{
    assert_true(size <= LOSSY_NVM_MAX);
    self->size = size;
    self->calls = 0;
    self->fail_from = self->fail_to = self->die_at = self->skip = LOSSY_NVM_NEVER;
    self->through = LOSSY_NVM_NOTHING;
    self->syncs = self->pending_count = self->log_length = 0;
    self->before_sync = NULL;
    memcpy(self->bytes, image, size);
    memcpy(self->durable, image, size);
}

struct dg_nvm lossy_nvm_port(struct lossy_nvm *self)
{
    static const struct dg_nvm_ops ops = {lossy_read, lossy_write, lossy_sync};
    return (struct dg_nvm){&ops, self};
}

/* --- what a power cut leaves --- */

enum { KEPT, LOST, TORN };
enum tear { REST_AS_BEFORE, REST_NOISE, REST_ONLY, TEARS };
#define SHORT 8u

static uint32_t boundaries(uint32_t n)
{
    return n <= SHORT ? n - 1u : 3u;
}

static uint32_t boundary(uint32_t n, uint32_t i)
{
    const uint32_t of_long[3] = {1, n / 2, n - 1};
    return n <= SHORT ? i + 1u : of_long[i];
}

static uint32_t fates(const struct lossy_nvm_write *write)
{
    return TORN + TEARS * boundaries(write->n);
}

/* Neither what was there nor what should be. */
static void make_noise(uint8_t *image, uint32_t from, uint32_t to)
{
    for (uint32_t i = from; i < to; i++) {
        image[i] = (uint8_t)(0x35u + i * 0x9Du);
    }
}

static void meet(const struct lossy_nvm *self, uint32_t i, uint32_t fate, uint8_t *image)
{
    const struct lossy_nvm_write *write = &self->pending[i];
    const uint8_t *from = self->log + write->at;
    uint8_t *to = image + write->address;
    if (fate == KEPT) {
        memcpy(to, from, write->n);
    }
    if (fate < TORN) {
        return;
    }
    const uint32_t k = boundary(write->n, (fate - TORN) / TEARS);
    const enum tear tear = (enum tear)((fate - TORN) % TEARS);
    if (tear == REST_ONLY) {
        memcpy(to + k, from + k, write->n - k);
        return;
    }
    memcpy(to, from, k);
    if (tear == REST_NOISE) {
        make_noise(image, write->address + k, write->address + write->n);
    }
}

static bool any_overlap(const struct lossy_nvm *self)
{
    for (uint32_t i = 1; i < self->pending_count; i++) {
        for (uint32_t j = 0; j < i; j++) {
            const struct lossy_nvm_write *a = &self->pending[i];
            const struct lossy_nvm_write *b = &self->pending[j];
            if (a->address < b->address + b->n && b->address < a->address + a->n) {
                return true;
            }
        }
    }
    return false;
}

struct search {
    const struct lossy_nvm *nvm;
    void (*see)(void *ctx, const uint8_t *image);
    void *ctx;
    uint64_t images;
    bool both_orders;
    uint16_t fate[LOSSY_NVM_PENDING];
    uint8_t image[LOSSY_NVM_MAX];
};

static void show(struct search *self)
{
    const uint32_t n = self->nvm->pending_count;
    memcpy(self->image, self->nvm->durable, self->nvm->size);
    for (uint32_t i = 0; i < n; i++) {
        meet(self->nvm, i, self->fate[i], self->image);
    }
    self->images++;
    self->see(self->ctx, self->image);
    if (self->both_orders) {
        memcpy(self->image, self->nvm->durable, self->nvm->size);
        for (uint32_t i = n; i-- > 0;) {
            meet(self->nvm, i, self->fate[i], self->image);
        }
        self->images++;
        self->see(self->ctx, self->image);
    }
}

/* All ways in which up to `left` of the writes from `first` on have another fate than now. */
static void deviate(struct search *self, uint32_t first, uint32_t left)
{
    show(self);
    for (uint32_t i = first; left > 0 && i < self->nvm->pending_count; i++) {
        const uint16_t usual = self->fate[i];
        const uint32_t count = fates(&self->nvm->pending[i]);
        for (uint32_t fate = 0; fate < count; fate++) {
            if (fate != usual) {
                self->fate[i] = (uint16_t)fate;
                deviate(self, i + 1, left - 1);
            }
        }
        self->fate[i] = usual;
    }
}

/* As little as the last write torn, or one lost or kept against all others. */
static void deviate_once(struct search *self, uint32_t there)
{
    const uint32_t count = fates(&self->nvm->pending[there]);
    for (uint32_t fate = 0; fate < count; fate++) {
        self->fate[there] = (uint16_t)fate;
        show(self);
    }
    for (uint16_t others = KEPT; others <= LOST; others++) {
        const uint16_t own = others == KEPT ? LOST : KEPT;
        for (uint32_t i = 0; i < self->nvm->pending_count; i++) {
            self->fate[i] = i == there ? own : others;
        }
        show(self);
    }
}

/* How many ways these are from one start: elementary symmetric polynomials, saturated. */
static uint32_t affordable(const struct lossy_nvm *self, double limit, bool *all)
{
    double ways[LOSSY_NVM_PENDING + 1] = {1};
    const uint32_t n = self->pending_count;
    for (uint32_t i = 0; i < n; i++) {
        for (uint32_t d = i + 1; d > 0; d--) {
            ways[d] += ways[d - 1] * (fates(&self->pending[i]) - 1u);
        }
    }
    double sum = 0;
    uint32_t depth = 0;
    for (uint32_t d = 0; d <= n; d++) {
        sum += ways[d];
        depth = sum * (n + 1) <= limit ? d : depth;
    }
    *all = sum <= limit;
    return depth;
}

struct lossy_nvm_count lossy_nvm_cut(const struct lossy_nvm *self, uint64_t limit,
                                     void (*see)(void *ctx, const uint8_t *image), void *ctx)
{
    struct search search = {.nvm = self, .see = see, .ctx = ctx};
    bool all = false;
    const uint32_t depth = affordable(self, (double)limit, &all);
    search.both_orders = any_overlap(self);
    if (all) {
        deviate(&search, 0, self->pending_count);
    }
    for (uint32_t there = 0; !all && there <= self->pending_count; there++) {
        for (uint32_t i = 0; i < self->pending_count; i++) {
            search.fate[i] = i < there ? KEPT : LOST;
        }
        if (depth > 0) {
            deviate(&search, 0, depth);
        } else if (there < self->pending_count) {
            deviate_once(&search, there);
        }
    }
    return (struct lossy_nvm_count){search.images, all};
}
