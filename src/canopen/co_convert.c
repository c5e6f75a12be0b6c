/* SPDX-License-Identifier: MIT */
/*
 * The EEPROM of one EDS file's device to that of another: the base's regions are the same, cells go
 * by their keys. What an image has is told by its region "objects", so that no file is needed:
 *
 *   header | journal | base's regions | objects: words, a word for each cell | cells ...
 */
#include <string.h>

#include "co_file.h"

#define HEADER_SIZE 12u

/* An image, with a layout as its file had it. */
struct image {
    struct dg_store store;
    struct dg_store_layout layout;
    struct dg_store_region regions[DG_STORE_REGIONS_MAX];
    uint32_t head[EDS_WORD_CELLS];
    uint16_t kept;
    uint16_t longs;     /* values of more than 32 bits */
    uint16_t long_kept; /* bytes of them */
    bool saved;
    uint8_t node_id;
};

struct converting {
    const struct dg_co_file *file;
    struct image from;
    struct dg_store to;
    void (*tell)(void *ctx, uint32_t key, enum dg_co_misfit why);
    void *ctx;
};

/* ------------------------------------------------------------ the image */

/* The layout's id of one of two headers. @return false: there is none */
static bool find_id(struct dg_nvm nvm, uint32_t *id)
{
    static const uint8_t magic[4] = {'d', 'g', 'e', '1'};
    uint8_t header[HEADER_SIZE];

    for (uint32_t at = 0; at <= HEADER_SIZE; at += HEADER_SIZE) {
        if (nvm.ops->read(nvm.ctx, at, header, sizeof header) == DG_OK &&
            memcmp(header, magic, sizeof magic) == 0) {
            *id = dg_load_le32(header + 4);
            return true;
        }
    }
    return false;
}

/* How long the copies of what has more than 32 bits are. */
static bool read_sizes(struct converting *self, struct dg_nvm nvm)
{
    const struct dg_store_layout *base = self->file->base->layout;
    struct image *from = &self->from;
    const uint32_t address =
        dg_store_address(base, base->region_count) + 4u * (EDS_WORD_CELLS + from->kept);
    uint32_t size = 0;

    for (uint32_t n = 0; n < from->longs && size <= EDS_LONGS_KEPT; n++) {
        uint8_t bytes[4];
        if (nvm.ops->read(nvm.ctx, address + 8u * n + 4u, bytes, sizeof bytes) != DG_OK) {
            return false;
        }
        size += EDS_LENGTH_SIZE + dg_load_le16(bytes);
    }
    from->long_kept = (uint16_t)size;
    return size <= EDS_LONGS_KEPT;
}

/* What the image tells of its file; it may be anything. */
static bool read_head(struct converting *self, struct dg_nvm nvm)
{
    const struct dg_store_layout *base = self->file->base->layout;
    const uint32_t most = (DG_STORE_REGIONS_MAX - 1u - base->region_count) * EDS_CELLS_A_REGION;
    struct image *from = &self->from;
    uint8_t bytes[4u * EDS_WORD_CELLS];

    if (nvm.ops->read(nvm.ctx, dg_store_address(base, base->region_count), bytes, sizeof bytes) !=
        DG_OK) {
        return false;
    }
    for (uint32_t n = 0; n < EDS_WORD_CELLS; n++) {
        from->head[n] = dg_load_le32(&bytes[(size_t)4u * n]);
    }
    from->kept = (uint16_t)from->head[EDS_WORD_KEPT];
    from->longs = (uint16_t)(from->head[EDS_WORD_KEPT] >> 16);
    return from->head[EDS_WORD_TAG] == dg_co_file_word(self->file, EDS_WORD_TAG) &&
           from->head[EDS_WORD_BASE] == base->id && from->head[EDS_WORD_KEPT] > 0 &&
           from->kept <= most && read_sizes(self, nvm);
}

static void make_image_layout(struct converting *self, uint32_t id)
{
    const struct dg_store_layout *base = self->file->base->layout;
    struct image *from = &self->from;
    uint8_t count = base->region_count;

    memcpy(from->regions, base->regions, count * sizeof *from->regions);
    from->regions[count++] = (struct dg_store_region){
        .name = "objects", .size = (uint16_t)(4u * eds_word_count(from->kept, from->longs))};
    for (uint32_t n = 0; n * EDS_CELLS_A_REGION < from->kept; n++) {
        from->regions[count++] = (struct dg_store_region){
            .name = "values",
            .size = (uint16_t)(4u * eds_cells_in(from->kept, n)),
            .check = DG_STORE_CHECKED,
        };
    }
    if (from->long_kept > 0 && count < DG_STORE_REGIONS_MAX) {
        from->regions[count++] = (struct dg_store_region){
            .name = "texts", .size = (uint16_t)(2u * (EDS_COPY_HEAD + from->long_kept))};
    }
    from->layout = *base;
    from->layout.id = id;
    from->layout.regions = from->regions;
    from->layout.region_count = count;
}

static int open_image(struct converting *self, struct dg_nvm nvm)
{
    struct image *from = &self->from;
    uint8_t bus[3] = {0};
    uint8_t saved = 0;
    uint32_t id = 0;

    if (!find_id(nvm, &id) || !read_head(self, nvm)) {
        return DG_ERR_FOREIGN;
    }
    make_image_layout(self, id);
    const int result = dg_store_mount(&from->store, &from->layout, nvm);
    if (result == DG_OK && !dg_store_damaged(&from->store, DG_CO_REGION_SAVED)) {
        (void)dg_store_read(&from->store, DG_CO_REGION_SAVED, 0, &saved, 1);
        (void)dg_store_read(&from->store, DG_CO_REGION_BUS, 0, bus, sizeof bus);
    }
    from->saved = saved == 1;
    from->node_id = bus[1];
    return result == DG_ERR_IO ? result : result == DG_OK ? DG_OK : DG_ERR_FOREIGN;
}

/* ------------------------------------------------------------ objects */

/* Key and type of a cell of the image. */
static uint32_t cell_word_of(struct converting *self, uint32_t n)
{
    uint8_t bytes[4] = {0};

    (void)dg_store_read(&self->from.store, self->file->base->layout->region_count,
                        (uint16_t)(4u * (EDS_WORD_CELLS + n)), bytes, sizeof bytes);
    return dg_load_le32(bytes);
}

/* Which cell of the image has this key; `kept`: none. */
static uint32_t find_cell(struct converting *self, uint32_t key)
{
    uint32_t first = 0;
    uint32_t last = self->from.kept;

    while (first < last) {
        const uint32_t middle = first + (last - first) / 2u;
        if ((cell_word_of(self, middle) & 0xFFFFFF00u) < key) {
            first = middle + 1u;
        } else {
            last = middle;
        }
    }
    return first < self->from.kept && (cell_word_of(self, first) & 0xFFFFFF00u) == key
               ? first
               : self->from.kept;
}

/* @return false: it cannot be read */
static bool read_cell(struct converting *self, uint32_t n, uint32_t *value)
{
    const uint8_t region =
        (uint8_t)(self->file->base->layout->region_count + 1u + n / EDS_CELLS_A_REGION);
    uint8_t bytes[4];

    if (dg_store_damaged(&self->from.store, region) ||
        dg_store_read(&self->from.store, region, (uint16_t)(4u * (n % EDS_CELLS_A_REGION)), bytes,
                      4) != DG_OK) {
        return false;
    }
    *value = dg_load_le32(bytes);
    return true;
}

static void tell_misfit(struct converting *self, uint32_t key, enum dg_co_misfit why)
{
    if (self->tell != NULL) {
        self->tell(self->ctx, key, why);
    }
}

/* What cell `n` of the file becomes: the image's value if it fits, else its default. */
static uint32_t convert_cell(struct converting *self, uint32_t n)
{
    const struct dg_co_cell *cell = &self->file->cells[n];
    const uint32_t initial = cell->initial + (cell->follows ? self->from.node_id : 0u);
    const uint32_t at = find_cell(self, cell->key);
    uint32_t value = initial;

    if (at == self->from.kept) {
        tell_misfit(self, cell->key, DG_CO_NEW);
    } else if ((cell_word_of(self, at) & 0xFFu) != cell->type) {
        tell_misfit(self, cell->key, DG_CO_RETYPED);
    } else if (self->from.saved && read_cell(self, at, &value) && !eds_is_inside(cell, value)) {
        tell_misfit(self, cell->key, DG_CO_OUTSIDE);
        value = initial;
    }
    return value;
}

static bool has_cell(const struct dg_co_file *file, uint32_t key)
{
    for (uint16_t i = 0; i < file->kept; i++) {
        if (file->cells[i].key == key) {
            return true;
        }
    }
    return false;
}

static void compare_rest(struct converting *self)
{
    static const uint32_t keys[EDS_WORD_CELLS] = {
        [EDS_WORD_TYPE] = DG_CO_KEY(0x1000, 0),
        [EDS_WORD_VENDOR] = DG_CO_KEY(0x1018, 1),
        [EDS_WORD_PRODUCT] = DG_CO_KEY(0x1018, 2),
        [EDS_WORD_REVISION] = DG_CO_KEY(0x1018, 3),
    };

    for (uint32_t n = EDS_WORD_TYPE; n <= EDS_WORD_REVISION; n++) {
        if (self->from.head[n] != dg_co_file_word(self->file, n)) {
            tell_misfit(self, keys[n], DG_CO_FOREIGN);
        }
    }
    for (uint32_t n = 0; n < self->from.kept; n++) {
        const uint32_t key = cell_word_of(self, n) & 0xFFFFFF00u;
        if (!has_cell(self->file, key)) {
            tell_misfit(self, key, DG_CO_GONE);
        }
    }
}

/* ------------------------------------------------------------ copying */

/* All of the base's; one that is damaged stays as delivered. */
static int copy_base_regions(struct converting *self)
{
    const struct dg_store_layout *base = self->file->base->layout;
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    int result = DG_OK;

    for (uint8_t n = 0; n < base->region_count && result == DG_OK; n++) {
        const uint16_t size = base->regions[n].size;
        if (!dg_store_damaged(&self->from.store, n) &&
            dg_store_read(&self->from.store, n, 0, bytes, size) == DG_OK) {
            result = dg_store_put(&self->to, n, 0, bytes, size);
        }
    }
    return result;
}

/* Values count when something was saved. */
static int convert_cells(struct converting *self, bool copied)
{
    const uint8_t first = (uint8_t)(self->file->base->layout->region_count + 1u);
    const uint16_t kept = self->file->kept;
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    int result = DG_OK;

    for (uint32_t n = 0; n * EDS_CELLS_A_REGION < kept && result == DG_OK; n++) {
        const uint16_t count = eds_cells_in(kept, n);
        for (uint16_t i = 0; i < count; i++) {
            dg_store_le32(&bytes[(size_t)4u * i], convert_cell(self, n * EDS_CELLS_A_REGION + i));
        }
        if (copied && self->from.saved) {
            result =
                dg_store_put(&self->to, (uint8_t)(first + n), 0, bytes, (uint16_t)(4u * count));
        }
    }
    return result;
}

static int convert_longs(struct converting *self, bool copied)
{
    const struct dg_co_convert_longs all = {
        .file = self->file,
        .from = &self->from.store,
        .to = copied ? &self->to : NULL,
        .tell = self->tell,
        .ctx = self->ctx,
        .first = EDS_WORD_CELLS + self->from.kept,
        .count = self->from.longs,
        .size = self->from.long_kept,
        .words = self->file->base->layout->region_count,
        .saved = self->from.saved,
    };

    return dg_co_convert_longs(&all);
}

int dg_co_convert(const struct dg_co_file *self, struct dg_nvm from, struct dg_nvm to,
                  void (*tell)(void *ctx, uint32_t key, enum dg_co_misfit why), void *ctx)
{
    struct converting all = {.file = self, .tell = tell, .ctx = ctx};
    int result = open_image(&all, from);

    if (result != DG_OK) {
        return result;
    }
    compare_rest(&all);
    if (to.ops == NULL) {
        result = convert_cells(&all, false);
        return result == DG_OK ? convert_longs(&all, false) : result;
    }
    result = dg_store_mount(&all.to, &self->layout, to);
    result = result == DG_OK ? copy_base_regions(&all) : result;
    result = result == DG_OK ? convert_cells(&all, true) : result;
    result = result == DG_OK ? convert_longs(&all, true) : result;
    if (result == DG_OK) {
        dg_co_write_words(self, &all.to);
    }
    return result;
}
