/* SPDX-License-Identifier: MIT */
/*
 * EEPROMs of models that are texts. The figures of one are a text in regions behind those of its
 * protocol, which nobody needs to run an encoder: damage of them is no fault of its EEPROM.
 */
#include "drehgeber/stamp.h"

#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/crc.h"
#include "drehgeber/text.h"

#define FIGURES_MAX ((size_t)DG_MODEL_STAMP_PARTS * DG_MODEL_STAMP_PART)
/* The store's: magic, id, size of the layout; a copy of it follows. */
#define HEADER_SIZE 12u
#define HEADER_ID 4u
#define HEADER_LENGTH 8u
/* Any layout's journal has room for so much of a region without a sum. */
#define CHUNK 64u

/* ---------------------------------------------------------------- lines */

static size_t value_length(const char *value)
{
    size_t n = 0;

    while (value[n] != '\0' && value[n] != '\n') {
        n++;
    }
    return n;
}

static size_t key_length(const char *line)
{
    size_t n = 0;

    while (line[n] != '\0' && line[n] != '\n' && line[n] != '=') {
        n++;
    }
    return n;
}

/* The line behind this one; NULL: there is none. */
static const char *next_line(const char *line)
{
    const size_t n = value_length(line);

    return line[n] == '\0' || line[n + 1u] == '\0' ? NULL : line + n + 1u;
}

static const char *first_line(const char *figures)
{
    return figures[0] == '\0' ? NULL : figures;
}

/* The value that a key of `n` characters has; NULL: none. */
static const char *find_value(const char *figures, const char *key, size_t n)
{
    for (const char *line = first_line(figures); line != NULL; line = next_line(line)) {
        if (key_length(line) == n && line[n] == '=' && dg_text_same(line, key, n, NULL)) {
            return line + n + 1u;
        }
    }
    return NULL;
}

static bool same_value(const char *a, const char *b)
{
    const size_t n = value_length(a);

    return value_length(b) == n && dg_text_same(a, b, n, NULL);
}

/* ---------------------------------------------------------------- a layout */

static void add_line(struct dg_text *to, const char *key, const char *value)
{
    dg_text_add(to, key);
    dg_text_add(to, "=");
    dg_text_add(to, value);
    dg_text_add(to, "\n");
}

static void write_figures(struct dg_model_stamp *self, const struct dg_model_text *text,
                          const void *model)
{
    struct dg_text to = dg_text_in(self->figures, sizeof self->figures);
    char value[DG_MODEL_STAMP_VALUE_MAX + 1u];

    add_line(&to, "protocol", text->stack->name);
    for (const char *const *name = self->memory->figures; *name != NULL; name++) {
        const struct dg_key *figure = dg_model_figure(text, *name);
        if (figure != NULL && dg_key_get(figure, model, value, sizeof value) >= 0) {
            add_line(&to, *name, value);
        }
    }
}

/* The regions of `base`, and behind them `parts` for figures. */
static void make_stamped_layout(struct dg_store_layout *to, struct dg_store_region *regions,
                                const struct dg_model_stamp *stamp, size_t parts)
{
    static const char *const names[DG_MODEL_STAMP_PARTS] = {"figures", "figures-2", "figures-3"};
    uint8_t count = stamp->base->region_count;

    memcpy(regions, stamp->base->regions, count * sizeof *regions);
    for (size_t i = 0; i < parts; i++) {
        regions[count++] = (struct dg_store_region){
            .name = names[i],
            .size = DG_MODEL_STAMP_PART,
            .check = DG_STORE_RAW,
            .defaults = stamp->memory->defaults[i],
        };
    }
    *to = *stamp->base;
    to->regions = regions;
    to->region_count = count;
}

static uint32_t make_id(const struct dg_model_stamp *self)
{
    uint8_t base[4];

    dg_store_le32(base, self->base->id);
    return dg_crc32(dg_crc32(0, base, sizeof base), (const uint8_t *)self->figures,
                    dg_text_length(self->figures, FIGURES_MAX));
}

/* Where a model of any protocol has its layout. */
struct slot {
    const struct dg_store_layout *layout;
};

static void set_layout(const struct dg_model_text *text, void *model,
                       const struct dg_store_layout *layout)
{
    const struct slot slot = {layout};

    memcpy((uint8_t *)model + text->memory->layout_at, &slot, sizeof slot);
}

void dg_model_stamp_make(struct dg_model_stamp *to, const struct dg_model_text *text, void *model)
{
    if (text->memory == NULL) {
        return;
    }
    *to = (struct dg_model_stamp){.memory = text->memory};
    set_layout(text, model, NULL);
    to->base = text->stack->layout(model);
    if (to->base == NULL) {
        return;
    }
    write_figures(to, text, model);
    const size_t n = dg_text_length(to->figures, FIGURES_MAX);
    make_stamped_layout(&to->layout, to->regions, to,
                        (n + DG_MODEL_STAMP_PART - 1u) / DG_MODEL_STAMP_PART);
    to->layout.id = make_id(to);
    set_layout(text, model, &to->layout);
}

const struct dg_model_stamp *dg_model_stamp_of(const struct dg_model_text *text, const void *model)
{
    struct slot slot = {NULL};

    if (text != NULL && text->memory != NULL) {
        memcpy(&slot, (const uint8_t *)model + text->memory->layout_at, sizeof slot);
    }
    return (const struct dg_model_stamp *)(const void *)slot.layout; /* its first member */
}

void dg_model_stamp_part(const struct dg_store_layout *layout, size_t part, uint8_t *out)
{
    const struct dg_model_stamp *self = (const struct dg_model_stamp *)(const void *)layout;

    memcpy(out, self->figures + part * DG_MODEL_STAMP_PART, DG_MODEL_STAMP_PART);
}

/* ---------------------------------------------------------------- an image */

/* With a layout as its model had it. */
struct image {
    struct dg_store store;
    struct dg_store_layout layout;
    struct dg_store_region regions[DG_STORE_REGIONS_MAX];
    char figures[FIGURES_MAX + 1u]; /* "": it has none */
};

/* It may be anything. */
static bool are_figures_printable(const char *figures)
{
    for (; *figures != '\0'; figures++) {
        if (*figures != '\n' && (*figures < ' ' || *figures > '~')) {
            return false;
        }
    }
    return true;
}

static void read_figures(struct image *self, uint8_t first)
{
    for (uint8_t region = first; region < self->store.region_count; region++) {
        char *to = self->figures + (size_t)(region - first) * DG_MODEL_STAMP_PART;
        if (dg_store_read(&self->store, region, 0, to, DG_MODEL_STAMP_PART) != DG_OK) {
            self->figures[0] = '\0';
        }
    }
    if (!are_figures_printable(self->figures)) {
        self->figures[0] = '\0';
    }
}

/* By the header at `at`. */
static int open_by(struct image *self, const struct dg_model_stamp *stamp, struct dg_nvm nvm,
                   uint32_t at)
{
    const uint32_t base = dg_store_size(stamp->base);
    uint8_t header[HEADER_SIZE];
    size_t parts = 0;

    if (nvm.ops->read(nvm.ctx, at, header, sizeof header) != DG_OK) {
        return DG_ERR_IO;
    }
    const uint32_t id = dg_load_le32(header + HEADER_ID);
    const uint32_t size = dg_load_le32(header + HEADER_LENGTH);
    if (id != stamp->base->id) {
        parts = size > base ? (size - base) / DG_MODEL_STAMP_PART : 0;
        if (parts == 0 || parts > DG_MODEL_STAMP_PARTS) {
            return DG_ERR_FOREIGN;
        }
    }
    make_stamped_layout(&self->layout, self->regions, stamp, parts);
    self->layout.id = id;
    return dg_store_mount(&self->store, &self->layout, nvm);
}

/* @return as dg_model_stamp_compare() */
static int open_stamped_image(struct image *self, const struct dg_model_stamp *stamp,
                              struct dg_nvm nvm)
{
    int result = open_by(self, stamp, nvm, 0);

    if (result == DG_ERR_FOREIGN) {
        result = open_by(self, stamp, nvm, HEADER_SIZE);
    }
    if (result != DG_OK && result != DG_ERR_OLDER) {
        return result == DG_ERR_IO ? result : DG_ERR_FOREIGN;
    }
    if (self->layout.id == stamp->base->id) {
        return DG_ERR_OLDER;
    }
    read_figures(self, stamp->base->region_count);
    if (self->layout.id == stamp->layout.id) {
        return DG_OK;
    }
    /* An image of another protocol might be as long. */
    return dg_text_same(self->figures, stamp->figures, value_length(stamp->figures) + 1u, NULL)
               ? DG_ERR_ARGUMENT
               : DG_ERR_FOREIGN;
}

/* ---------------------------------------------------------------- comparing */

struct comparing {
    void (*tell)(void *ctx, const struct dg_model_misfit *misfit);
    void *ctx;
};

/* Of a line, as a text of its own. */
static const char *copy_value(const char *value, char *to)
{
    struct dg_text copy = dg_text_in(to, DG_MODEL_STAMP_VALUE_MAX + 1u);

    dg_text_add_n(&copy, value, value_length(value));
    return to;
}

static void tell_figure_misfit(const struct comparing *self, const char *line, const char *found,
                               const char *expected)
{
    char key[DG_MODEL_STAMP_VALUE_MAX + 1u];
    char values[2][DG_MODEL_STAMP_VALUE_MAX + 1u];
    struct dg_text copy = dg_text_in(key, sizeof key);

    dg_text_add_n(&copy, line, key_length(line));
    const struct dg_model_misfit misfit = {
        .key = key,
        .found = found == NULL ? NULL : copy_value(found, values[0]),
        .expected = expected == NULL ? NULL : copy_value(expected, values[1]),
    };
    self->tell(self->ctx, &misfit);
}

static void compare_figures(const struct comparing *self, const char *expected, const char *found)
{
    const char *line = first_line(expected);

    for (; line != NULL; line = next_line(line)) {
        const size_t n = key_length(line);
        const char *value = find_value(found, line, n);
        if (value == NULL || !same_value(value, line + n + 1u)) {
            tell_figure_misfit(self, line, value, line + n + 1u);
        }
    }
    for (line = first_line(found); line != NULL; line = next_line(line)) {
        const size_t n = key_length(line);
        if (line[n] == '=' && find_value(expected, line, n) == NULL) {
            tell_figure_misfit(self, line, line + n + 1u, NULL);
        }
    }
}

int dg_model_stamp_compare(const struct dg_model_stamp *self, struct dg_nvm nvm,
                           void (*tell)(void *ctx, const struct dg_model_misfit *misfit), void *ctx)
{
    struct image image = {.layout = {.id = 0}};
    const int result = open_stamped_image(&image, self, nvm);

    if (result == DG_ERR_ARGUMENT && tell != NULL) {
        compare_figures(&(struct comparing){tell, ctx}, self->figures, image.figures);
    }
    return result;
}

/* ---------------------------------------------------------------- converting */

static bool keeps(const struct dg_model_stamp *self, const struct image *from,
                  const struct dg_model_kept *row)
{
    for (const char *const *need = row->needs; need != NULL && *need != NULL; need++) {
        const size_t n = dg_text_length(*need, DG_MODEL_STAMP_VALUE_MAX);
        const char *found = find_value(from->figures, *need, n);
        const char *expected = find_value(self->figures, *need, n);
        if (found == NULL || expected == NULL || !same_value(found, expected)) {
            return false;
        }
    }
    return true;
}

/* One that is damaged, or not there yet, stays as delivered. */
static int copy_region(struct image *from, struct dg_store *to, uint8_t region)
{
    const struct dg_store_region *row = &from->layout.regions[region];
    const uint16_t most = row->check == DG_STORE_CHECKED ? row->size : CHUNK;
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    int result = DG_OK;

    if (region >= from->store.region_count || dg_store_damaged(&from->store, region)) {
        return DG_OK;
    }
    for (uint16_t at = 0; at < row->size && result == DG_OK; at = (uint16_t)(at + most)) {
        const uint16_t rest = (uint16_t)(row->size - at);
        const uint16_t n = rest < most ? rest : most;
        result = dg_store_read(&from->store, region, at, bytes, n);
        result = result == DG_OK ? dg_store_put(to, region, at, bytes, n) : result;
    }
    return result;
}

int dg_model_stamp_convert(const struct dg_model_stamp *self, struct dg_nvm from, struct dg_nvm to,
                           void (*tell)(void *ctx, const char *what), void *ctx)
{
    struct image image = {.layout = {.id = 0}};
    struct dg_store store;
    int result = open_stamped_image(&image, self, from);

    if (result == DG_ERR_FOREIGN || result == DG_ERR_IO) {
        return result;
    }
    result = dg_store_mount(&store, &self->layout, to);
    for (size_t i = 0; i < self->memory->kept_count && result == DG_OK; i++) {
        const struct dg_model_kept *row = &self->memory->kept[i];
        if (!keeps(self, &image, row)) {
            if (row->what != NULL && tell != NULL) {
                tell(ctx, row->what);
            }
            continue;
        }
        for (uint8_t region = row->first; region <= row->last && result == DG_OK; region++) {
            result = copy_region(&image, &store, region);
        }
    }
    return result;
}
