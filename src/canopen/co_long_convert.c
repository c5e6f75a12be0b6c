/* SPDX-License-Identifier: MIT */
/*
 * Texts, domains and wide numbers from the EEPROM of one EDS file's device to that of another.
 */
#include <string.h>

#include "co_file.h"
#include "drehgeber/crc.h"

#define WORDS 2u /* of each value */

static void tell_misfit(const struct dg_co_convert_longs *self, uint32_t key, enum dg_co_misfit why)
{
    if (self->tell != NULL) {
        self->tell(self->ctx, key, why);
    }
}

static uint32_t long_word_of(const struct dg_co_convert_longs *self, uint32_t n)
{
    uint8_t bytes[4] = {0};

    (void)dg_store_read(self->from, self->words, (uint16_t)(4u * (self->first + n)), bytes,
                        sizeof bytes);
    return dg_load_le32(bytes);
}

/* The next value of the image; `kept` is the one before it, or 0. */
static void take_next(const struct dg_co_convert_longs *self, uint32_t n, struct dg_co_kept *kept)
{
    const uint32_t head = long_word_of(self, WORDS * n);
    const uint32_t sizes = long_word_of(self, WORDS * n + 1u);

    kept->at += n > 0 ? EDS_LENGTH_SIZE + kept->most : 0u;
    kept->key = head & 0xFFFFFF00u;
    kept->kind = (uint8_t)head;
    kept->most = (uint16_t)sizes;
    kept->least = (uint16_t)(sizes >> 16);
}

static bool find_kept(const struct dg_co_convert_longs *self, uint32_t key, struct dg_co_kept *kept)
{
    *kept = (struct dg_co_kept){0};
    for (uint32_t n = 0; n < self->count; n++) {
        take_next(self, n, kept);
        if (kept->key == key) {
            return true;
        }
    }
    return false;
}

/* What of the image there is no value for. */
static void tell_gone(const struct dg_co_convert_longs *self)
{
    struct dg_co_kept kept = {0};

    for (uint32_t n = 0; n < self->count; n++) {
        take_next(self, n, &kept);
        const struct dg_co_long *one = dg_co_find_long(self->file, kept.key);
        if (one == NULL || !one->kept) {
            tell_misfit(self, kept.key, DG_CO_GONE);
        }
    }
}

/* The value of the image, length and bytes, if it fits; else `bytes` stay. */
static void convert_one(const struct dg_co_convert_longs *self, struct dg_co_copies *from,
                        const struct dg_co_long *one, uint8_t *bytes)
{
    uint8_t found[EDS_LENGTH_SIZE + DG_EDS_LONG_MAX];
    struct dg_co_kept kept;

    if (!find_kept(self, one->key, &kept)) {
        tell_misfit(self, one->key, DG_CO_NEW);
        return;
    }
    if (kept.kind != one->kind || (one->least > 0 && kept.most != one->most) ||
        kept.most > DG_EDS_LONG_MAX) {
        tell_misfit(self, one->key, DG_CO_RETYPED);
        return;
    }
    const uint16_t size = (uint16_t)(EDS_LENGTH_SIZE + kept.most);
    if (!self->saved || !dg_co_read_copy(from, kept.at, found, size)) {
        return;
    }
    const uint16_t n = dg_load_le16(found);
    if (n < one->least || n > one->most || n > kept.most ||
        !dg_co_long_is_inside(one, &found[EDS_LENGTH_SIZE])) {
        tell_misfit(self, one->key, DG_CO_OUTSIDE);
        return;
    }
    memcpy(bytes, found, EDS_LENGTH_SIZE + n);
}

int dg_co_convert_longs(const struct dg_co_convert_longs *self)
{
    const struct dg_co_file *file = self->file;
    struct dg_co_copies from = {.found = false};
    struct dg_co_copies to = {.found = false};
    uint16_t sum = 0;
    int result = DG_OK;

    if (self->size > 0) {
        from = dg_co_open_copies(self->from, (uint8_t)(self->from->layout->region_count - 1u),
                                 self->size);
    }
    if (self->to != NULL && file->long_kept > 0) {
        to =
            dg_co_open_copies(self->to, (uint8_t)(file->layout.region_count - 1u), file->long_kept);
    }
    tell_gone(self);
    for (uint16_t i = 0; i < file->long_count && result == DG_OK; i++) {
        const struct dg_co_long *one = &file->longs[i];
        uint8_t bytes[EDS_LENGTH_SIZE + DG_EDS_LONG_MAX] = {0};
        const uint16_t size = (uint16_t)(EDS_LENGTH_SIZE + one->most);
        if (!one->kept) {
            continue;
        }
        dg_store_le16(bytes, one->n);
        memcpy(&bytes[EDS_LENGTH_SIZE], one->initial, one->n);
        convert_one(self, &from, one, bytes);
        sum = dg_crc16(sum, bytes, size);
        result = to.store != NULL ? dg_co_write_copy(&to, one->at, bytes, size) : DG_OK;
    }
    return result == DG_OK && to.store != NULL ? dg_co_end_copy(&to, sum) : result;
}
