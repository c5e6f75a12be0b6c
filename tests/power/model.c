/* SPDX-License-Identifier: MIT */
#include "model.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/crc.h"

/* --- versions --- */

static uint32_t first_byte(const struct model *self)
{
    return dg_store_address(self->layout, 0);
}

static bool shows(const struct model *self, const struct model_version *version,
                  const uint8_t *image, uint8_t regions)
{
    const uint32_t from = first_byte(self);
    const uint32_t to = dg_store_address(self->layout, regions);
    return version->regions == regions &&
           memcmp(version->bytes + from, image + from, to - from) == 0;
}

/* The one of `versions` that `image` shows, or 0. */
static uint64_t shown(const struct model *self, uint64_t versions, const uint8_t *image,
                      uint8_t regions)
{
    for (uint32_t i = 0; i < self->version_count; i++) {
        if ((versions >> i & 1u) != 0 && shows(self, &self->version[i], image, regions)) {
            return (uint64_t)1 << i;
        }
    }
    return 0;
}

/* The last one, unless it is there already. */
static uint64_t keep_last(struct model *self)
{
    const struct model_version *last = &self->version[self->version_count];
    const uint64_t all = ((uint64_t)1 << self->version_count) - 1u;
    const uint64_t known = shown(self, all, last->bytes, last->regions);
    if (known != 0) {
        return known;
    }
    assert_true(self->version_count + 1 < MODEL_VERSIONS);
    return (uint64_t)1 << self->version_count++;
}

static struct model_version *last_from(struct model *self, uint32_t i)
{
    self->version[self->version_count] = self->version[i];
    return &self->version[self->version_count];
}

static uint8_t content(uint8_t seed, uint8_t region, uint16_t i)
{
    return (uint8_t)(seed * 37u + region * 11u + i * 3u);
}

static void make_change(const struct model *self, struct model_version *version,
                        const struct model_change *change)
{
    for (uint8_t p = 0; p < change->count; p++) {
        const uint8_t region = change->part[p].region;
        const uint16_t n = change->part[p].n;
        uint8_t *to =
            version->bytes + dg_store_address(self->layout, region) + change->part[p].offset;
        for (uint16_t i = 0; i < n; i++) {
            to[i] = content((uint8_t)(change->seed + p), region, i);
        }
        if (self->layout->regions[region].check == DG_STORE_CHECKED) {
            dg_store_be16(to + n, dg_crc16(0xFFFF, to, n));
        }
    }
}

uint64_t model_with(struct model *self, uint64_t versions, const struct model_change *change)
{
    uint64_t result = 0;
    for (uint32_t i = 0; i < 63; i++) {
        if ((versions >> i & 1u) != 0) {
            make_change(self, last_from(self, i), change);
            result |= keep_last(self);
        }
    }
    return result;
}

/* Older releases' versions with the layout's other regions as delivered. */
static uint64_t grown(struct model *self, uint64_t versions)
{
    uint64_t result = 0;
    for (uint32_t i = 0; i < 63; i++) {
        if ((versions >> i & 1u) != 0) {
            struct model_version *version = last_from(self, i);
            const uint32_t from = dg_store_address(self->layout, version->regions);
            version->regions = self->layout->region_count;
            memcpy(version->bytes + from, self->delivered + from,
                   dg_store_size(self->layout) - from);
            result |= keep_last(self);
        }
    }
    return result;
}

/* --- images that were mounted --- */

static uint64_t mix(uint64_t hash, uint64_t word)
{
    hash = (hash ^ word) * 0x9E3779B97F4A7C15u;
    return hash ^ hash >> 29;
}

static uint64_t hash_of(const uint8_t *image, uint32_t n, uint64_t acceptable)
{
    uint64_t hash = mix(0x2545F4914F6CDD1Du, acceptable);
    for (uint32_t i = 0; i < n; i += 8) {
        uint64_t word = 0;
        memcpy(&word, image + i, n - i < 8 ? n - i : 8);
        hash = mix(hash, word);
    }
    return hash | 1u; /* 0 is an empty place */
}

static size_t place_of(const struct model *self, uint64_t hash)
{
    size_t at = (size_t)(hash >> 20) & (self->seen_size - 1);
    while (self->seen[at] != 0 && self->seen[at] != hash) {
        at = (at + 1) & (self->seen_size - 1);
    }
    return at;
}

static void make_room(struct model *self)
{
    uint64_t *old = self->seen;
    const size_t size = self->seen_size;
    self->seen_size = 2 * size;
    self->seen = calloc(self->seen_size, sizeof *self->seen);
    assert_non_null(self->seen);
    for (size_t i = 0; i < size; i++) {
        if (old[i] != 0) {
            self->seen[place_of(self, old[i])] = old[i];
        }
    }
    free(old);
}

/* Whether it was there already. */
static bool see_again(struct model *self, uint64_t hash)
{
    if (2 * self->seen_count >= self->seen_size) {
        make_room(self);
    }
    const size_t at = place_of(self, hash);
    if (self->seen[at] == hash) {
        return true;
    }
    self->seen[at] = hash;
    self->seen_count++;
    return false;
}

/* --- the search --- */

static void complain(const struct model_run *run, const char *what, int result)
{
    struct model *model = run->model;
    if (model->violations++ == 0) {
        (void)snprintf(model->first, sizeof model->first, "%s: %s (%d), %u cuts before",
                       model->name, what, result, run->depth);
    }
}

static void look_before_sync(void *ctx)
{
    model_look(ctx);
}

/* The next operation of the store is this one. */
static void enter(struct model_run *run, enum model_operation operation)
{
    run->nvm->syncs = 0;
    run->nvm->skip = run->model->broken == operation ? run->model->skip : LOSSY_NVM_NEVER;
    run->nvm->before_sync = look_before_sync;
    run->nvm->ctx = run;
}

static bool dead(const struct model_run *run)
{
    return run->nvm->calls >= run->nvm->die_at;
}

static void check_shown(struct model_run *run, const struct dg_store *store, int result)
{
    const uint64_t version =
        shown(run->model, run->acceptable, run->nvm->bytes, store->region_count);
    if (store->damaged != 0) {
        complain(run, "a region fails its check", (int)store->damaged);
    } else if (version == 0) {
        complain(run, "neither old nor new", result);
    } else {
        run->acceptable = version;
    }
}

/* An older image that is shown may be the grown one from now on. */
static int grow(struct model_run *run, struct dg_store *store)
{
    check_shown(run, store, DG_ERR_OLDER);
    run->acceptable |= grown(run->model, run->acceptable);
    enter(run, MODEL_GROW);
    return dg_store_grow(store, run->model->ctx);
}

int model_take_over(struct model_run *run, struct dg_store *store)
{
    enter(run, MODEL_MOUNT);
    int result = dg_store_mount(store, run->model->layout, lossy_nvm_port(run->nvm));
    if (result == DG_ERR_OLDER) {
        result = grow(run, store);
    }
    if (result == DG_OK) {
        check_shown(run, store, result);
    }
    if (!dead(run)) {
        model_look(run);
    }
    return result;
}

/* Mount what a power cut left. */
static void see(void *ctx, const uint8_t *image)
{
    const struct model_run *before = ctx;
    struct model *model = before->model;
    struct dg_store store;
    const uint32_t size = before->nvm->size;
    /* What is done with it depends on these, too. */
    const uint64_t key = mix(before->acceptable, 2u * before->depth + (before->again != NULL));
    model->states++;
    model->recovery_states += before->depth > 0;
    const uint64_t hash = hash_of(image, size, key);
    if (see_again(model, hash)) {
        return;
    }
    model->images++;
    struct lossy_nvm *nvm = malloc(sizeof *nvm);
    assert_non_null(nvm);
    lossy_nvm_init(nvm, image, size);
    struct model_run run = {model, nvm, before->acceptable, before->depth + 1, NULL};
    const int result = model_take_over(&run, &store);
    const bool refused =
        result == DG_ERR_BLANK && dg_store_unfinished(model->layout, lossy_nvm_port(nvm));
    if (refused ? (before->acceptable & MODEL_REFUSED) == 0 : result != DG_OK) {
        complain(&run, "mount", result);
    } else if (!refused && before->again != NULL && (hash >> 8) % model->again_every == 0) {
        (void)model_commit(&run, &store, before->again);
    }
    free(nvm);
}

void model_look(struct model_run *run)
{
    struct model *model = run->model;
    if (run->depth >= model->cuts) {
        return;
    }
    const uint64_t limit = run->depth == 0 ? model->limit : model->recovery_limit;
    const struct lossy_nvm_count count = lossy_nvm_cut(run->nvm, limit, see, run);
    model->moments++;
    model->whole_moments += count.all;
}

int model_stage(struct dg_store *store, const struct model_change *change)
{
    int result = DG_OK;
    dg_store_begin(store);
    for (uint8_t p = 0; result == DG_OK && p < change->count; p++) {
        uint8_t bytes[256];
        const uint16_t n = change->part[p].n;
        for (uint16_t i = 0; i < n; i++) {
            bytes[i] = content((uint8_t)(change->seed + p), change->part[p].region, i);
        }
        result = dg_store_stage(store, change->part[p].region, change->part[p].offset, bytes, n);
    }
    return result;
}

/* Until commit is called nothing new may show. */
int model_commit(struct model_run *run, struct dg_store *store, const struct model_change *change)
{
    enter(run, MODEL_COMMIT);
    int result = model_stage(store, change);
    if (!dead(run)) {
        model_look(run);
    }
    if (result != DG_OK) {
        return result;
    }
    const uint64_t changed = model_with(run->model, run->acceptable, change);
    run->acceptable |= changed;
    result = dg_store_commit(store);
    if (result == DG_OK) {
        run->acceptable = changed;
        check_shown(run, store, result);
    }
    if (!dead(run)) {
        model_look(run);
    }
    return result;
}

int model_read(struct model_run *run, struct dg_store *store)
{
    uint8_t byte = 0;
    enter(run, MODEL_COMMIT);
    const int result = dg_store_read(store, 0, 0, &byte, 1);
    if (result == DG_OK) {
        check_shown(run, store, result);
    }
    if (!dead(run)) {
        model_look(run);
    }
    return result;
}

#define FORMAT_SYNCS 5u

/* Up to the second sync the old image may still be there, before the last but one the new one. */
struct format_run {
    struct model_run *run;
    uint64_t before[FORMAT_SYNCS];
};

static void look_while_formatting(void *ctx)
{
    struct format_run *self = ctx;
    const uint32_t nth = self->run->nvm->syncs - 1; /* it counts the one under way */
    self->run->acceptable = self->before[nth < FORMAT_SYNCS ? nth : FORMAT_SYNCS - 1u];
    model_look(self->run);
}

int model_format(struct model_run *run)
{
    struct model *model = run->model;
    model->version[model->version_count].regions = model->layout->region_count;
    memcpy(model->version[model->version_count].bytes, model->delivered, sizeof model->delivered);
    const uint64_t delivered = keep_last(model);
    struct format_run format = {run,
                                {run->acceptable, run->acceptable | MODEL_REFUSED, MODEL_REFUSED,
                                 MODEL_REFUSED | delivered, delivered}};
    enter(run, MODEL_FORMAT);
    run->nvm->before_sync = look_while_formatting;
    run->nvm->ctx = &format;
    const int result = dg_store_format(model->layout, lossy_nvm_port(run->nvm), model->ctx);
    run->acceptable = delivered;
    model_look(run);
    return result;
}

/* --- the model --- */

static int make_delivered(struct model *self)
{
    struct lossy_nvm *nvm = malloc(sizeof *nvm);
    assert_non_null(nvm);
    memset(self->delivered, 0xFF, sizeof self->delivered);
    lossy_nvm_init(nvm, self->delivered, dg_store_size(self->layout));
    const int result = dg_store_format(self->layout, lossy_nvm_port(nvm), self->ctx);
    memcpy(self->delivered, nvm->bytes, nvm->size);
    free(nvm);
    return result;
}

int model_init(struct model *self, const char *name, const struct dg_store_layout *layout,
               const void *ctx, uint64_t limit)
{
    memset(self, 0, sizeof *self);
    self->name = name;
    self->layout = layout;
    self->ctx = ctx;
    self->limit = limit;
    self->recovery_limit = 30 + limit / 1000;
    self->again_every = 16;
    self->cuts = 2;
    self->skip = LOSSY_NVM_NEVER;
    self->seen_size = (size_t)1 << 16;
    self->seen = calloc(self->seen_size, sizeof *self->seen);
    assert_non_null(self->seen);
    return make_delivered(self);
}

void model_free(struct model *self)
{
    free(self->seen);
}

uint64_t model_start(struct model *self, const uint8_t *image, uint8_t regions)
{
    memset(self->seen, 0, self->seen_size * sizeof *self->seen);
    self->seen_count = 0;
    self->version_count = 0;
    self->version[0].regions = regions;
    memcpy(self->version[0].bytes, image, dg_store_size(self->layout));
    return keep_last(self);
}
