/* SPDX-License-Identifier: MIT */
/*
 * Values of a file that only store: in memory behind the application's, in regions of the EEPROM
 * behind the base's.
 */
#include <string.h>

#include "co_file.h"
#include "co_storage.h"

#define SAVE 0x65766173u

uint32_t *dg_co_cells(const struct dg_co_node *node)
{
    uint8_t *application = node->setup.application;

    return (uint32_t *)(void *)(application + co_file_of(node)->cells_at);
}

enum dg_co_type dg_co_type_at(const struct dg_co_device *device, uint32_t key)
{
    struct dg_co_object object;

    return dg_co_find(device, key, &object) == DG_CO_OK ? co_type(&object) : DG_CO_TYPE_COUNT;
}

uint32_t dg_co_value_of(const struct dg_co_node *node, uint32_t key)
{
    struct dg_co_object object;

    if (dg_co_find(node->setup.device, key, &object) != DG_CO_OK) {
        return 0;
    }
    const uint32_t initial = object.row->initial;
    return co_hook(&object) == dg_co_hook_cell ? dg_co_cells(node)[initial] : initial;
}

/* The default of its row is the number of its cell. */
enum dg_co_abort dg_co_hook_cell(struct dg_co_node *node, const struct dg_co_object *object,
                                 enum dg_co_op op, uint32_t *value)
{
    const uint32_t number = object->row->initial;

    if (op == DG_CO_READ) {
        *value = dg_co_cells(node)[number];
        return DG_CO_OK;
    }
    if (!eds_is_inside(&co_file_of(node)->cells[number], *value)) {
        return DG_CO_RANGE;
    }
    dg_co_cells(node)[number] = *value;
    return DG_CO_OK;
}

enum dg_co_abort dg_co_hook_follows(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    (void)op;
    *value = object->row->initial + node->id;
    return DG_CO_OK;
}

/* ------------------------------------------------------------ what an image tells */

#define TAG 0x31534445u /* "EDS1" */

/* Word `n` of those that are kept: two for each. */
static uint32_t long_word(const struct dg_co_file *self, uint32_t n)
{
    const struct dg_co_long *one = self->longs;

    for (uint32_t left = n / 2u + 1u; left > 0; one++) {
        left -= one->kept ? 1u : 0u;
    }
    one--;
    return n % 2u == 0 ? one->key | one->kind : one->most | (uint32_t)one->least << 16;
}

uint32_t dg_co_file_word(const struct dg_co_file *self, uint32_t n)
{
    const struct dg_co_device *device = &self->device;
    const uint32_t head[EDS_WORD_CELLS] = {
        [EDS_WORD_TAG] = TAG,
        [EDS_WORD_BASE] = self->base->layout->id,
        [EDS_WORD_TYPE] = device->device_type,
        [EDS_WORD_VENDOR] = device->vendor_id,
        [EDS_WORD_PRODUCT] = device->product_code,
        [EDS_WORD_REVISION] = device->revision,
        [EDS_WORD_KEPT] = self->kept | (uint32_t)self->longs_kept << 16,
    };

    if (n < EDS_WORD_CELLS) {
        return head[n];
    }
    n -= EDS_WORD_CELLS;
    return n < self->kept ? self->cells[n].key | self->cells[n].type
                          : long_word(self, n - self->kept);
}

void dg_co_write_words(const struct dg_co_file *self, struct dg_store *store)
{
    const uint8_t region = self->base->layout->region_count;
    const uint32_t count = eds_word_count(self->kept, self->longs_kept);

    for (uint32_t first = 0; first < count; first += EDS_CELLS_A_REGION) {
        const uint32_t left = count - first;
        const uint32_t words = left < EDS_CELLS_A_REGION ? left : EDS_CELLS_A_REGION;
        const uint16_t at = (uint16_t)(4u * first);
        const uint16_t n = (uint16_t)(4u * words);
        uint8_t right[DG_STORE_CHECKED_MAX] = {0};
        uint8_t found[DG_STORE_CHECKED_MAX];
        for (uint32_t i = 0; i < words; i++) {
            dg_store_le32(&right[(size_t)4u * i], dg_co_file_word(self, first + i));
        }
        if (dg_store_read(store, region, at, found, n) == DG_OK && memcmp(right, found, n) != 0) {
            (void)dg_store_put(store, region, at, right, n);
        }
    }
}

/* ------------------------------------------------------------ saving, loading */

/* The first region of cells. */
static uint8_t first_of(const struct dg_co_file *file)
{
    return (uint8_t)(file->base->layout->region_count + 1u);
}

static void store_cells(struct dg_co_node *node)
{
    const struct dg_co_file *file = co_file_of(node);
    const uint8_t first = first_of(file);
    const uint32_t *value = dg_co_cells(node);
    uint8_t bytes[DG_STORE_CHECKED_MAX];

    dg_co_write_words(file, &node->store);
    dg_co_save_longs(node);
    for (uint8_t n = 0; n * EDS_CELLS_A_REGION < file->kept; n++) {
        const uint16_t count = eds_cells_in(file->kept, n);
        for (uint16_t i = 0; i < count; i++) {
            dg_store_le32(&bytes[(size_t)4u * i], *value++);
        }
        /* What is not written now is not acknowledged either: the stack's own part follows. */
        (void)dg_store_put(&node->store, (uint8_t)(first + n), 0, bytes, (uint16_t)(4u * count));
    }
}

/* "save": the cells first, so that they are there when the rest says that something was saved. */
enum dg_co_abort dg_co_hook_keep(struct dg_co_node *node, const struct dg_co_object *object,
                                 enum dg_co_op op, uint32_t *value)
{
    if (op == DG_CO_WRITE && *value == SAVE && node->mounted &&
        node->setup.world->eeprom_acknowledges) {
        store_cells(node);
    }
    return dg_co_hook_store(node, object, op, value);
}

static bool are_cells_saved(struct dg_co_node *node)
{
    uint8_t saved = 0;

    return node->mounted && node->setup.world->eeprom_acknowledges &&
           !dg_store_damaged(&node->store, DG_CO_REGION_SAVED) &&
           dg_store_read(&node->store, DG_CO_REGION_SAVED, 0, &saved, 1) == DG_OK && saved == 1;
}

/* What is damaged stays as delivered, and is reported with the rest of the memory. */
static void load_cells(struct dg_co_node *node)
{
    const struct dg_co_file *file = co_file_of(node);
    const uint8_t first = first_of(file);
    uint8_t bytes[DG_STORE_CHECKED_MAX];

    dg_co_load_longs(node);
    for (uint8_t n = 0; n * EDS_CELLS_A_REGION < file->kept; n++) {
        const uint8_t region = (uint8_t)(first + n);
        const uint16_t count = eds_cells_in(file->kept, n);
        uint32_t *value = dg_co_cells(node) + (size_t)n * EDS_CELLS_A_REGION;
        if (dg_store_damaged(&node->store, region) ||
            dg_store_read(&node->store, region, 0, bytes, (uint16_t)(4u * count)) != DG_OK) {
            continue;
        }
        for (uint16_t i = 0; i < count; i++) {
            value[i] = dg_load_le32(&bytes[(size_t)4u * i]);
        }
    }
}

bool dg_co_reset_file(struct dg_co_node *node, bool application)
{
    const struct dg_co_file *file = co_file_of(node);

    for (uint16_t i = 0; application && i < file->cell_count; i++) {
        const struct dg_co_cell *cell = &file->cells[i];
        dg_co_cells(node)[i] = cell->initial + (cell->follows ? node->id : 0u);
    }
    if (application) {
        dg_co_reset_longs(node);
    }
    if (application && are_cells_saved(node)) {
        load_cells(node);
    }
    return file->base->reset != NULL && file->base->reset(node, application);
}
