/* SPDX-License-Identifier: MIT */
/*
 * Texts, domains and wide numbers that 1010h keeps. The last region has two copies of them, so that
 * a power cut leaves the older one or the newer:
 *
 *   number, 2 | CRC-16, 2 | as they lie in memory | the same again
 *
 * "save" writes the copy that is not in force: the values in parts, then number and sum at once.
 */
#include <string.h>

#include "co_file.h"
#include "drehgeber/crc.h"

#define NO_NUMBER 0xFFFFu /* of a memory that was never written */

static uint16_t copy_place_of(const struct dg_co_copies *self, uint8_t copy)
{
    return (uint16_t)(copy * (EDS_COPY_HEAD + self->size));
}

static uint16_t least_of(uint32_t left)
{
    return (uint16_t)(left < DG_STORE_CHECKED_MAX ? left : DG_STORE_CHECKED_MAX);
}

/* @return false: it cannot be read, or was never written */
static bool read_number(struct dg_co_copies *self, uint8_t copy, uint16_t *number)
{
    const uint16_t place = copy_place_of(self, copy);
    uint8_t head[EDS_COPY_HEAD];
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    uint16_t sum = 0;

    if (dg_store_read(self->store, self->region, place, head, sizeof head) != DG_OK) {
        return false;
    }
    for (uint16_t at = 0; at < self->size; at = (uint16_t)(at + DG_STORE_CHECKED_MAX)) {
        const uint16_t n = least_of((uint32_t)self->size - at);
        if (dg_store_read(self->store, self->region, (uint16_t)(place + EDS_COPY_HEAD + at), bytes,
                          n) != DG_OK) {
            return false;
        }
        sum = dg_crc16(sum, bytes, n);
    }
    *number = dg_load_le16(head);
    return *number != NO_NUMBER && dg_load_le16(&head[2]) == sum;
}

/* The one in force; of two the one with the next number. */
static bool find_newest(struct dg_co_copies *self)
{
    uint16_t number[2] = {0};
    const bool good[2] = {read_number(self, 0, &number[0]), read_number(self, 1, &number[1])};
    const bool later = number[1] == (number[0] + 1u) % NO_NUMBER;

    self->newest = good[1] && (later || !good[0]) ? 1 : 0;
    self->number = number[self->newest];
    return good[0] || good[1];
}

struct dg_co_copies dg_co_open_copies(struct dg_store *store, uint8_t region, uint16_t size)
{
    struct dg_co_copies self = {.store = store, .region = region, .size = size};

    self.found = find_newest(&self);
    return self;
}

bool dg_co_read_copy(struct dg_co_copies *self, uint32_t at, uint8_t *to, uint16_t n)
{
    const uint32_t place = copy_place_of(self, self->newest) + EDS_COPY_HEAD + at;

    return self->found && dg_store_read(self->store, self->region, (uint16_t)place, to, n) == DG_OK;
}

/* In parts that the journal takes. */
int dg_co_write_copy(struct dg_co_copies *self, uint32_t at, const uint8_t *from, uint16_t n)
{
    const uint8_t copy = (uint8_t)(self->found ? 1u - self->newest : 0u);
    const uint32_t place = copy_place_of(self, copy) + EDS_COPY_HEAD + at;
    int result = DG_OK;

    for (uint16_t done = 0; done < n && result == DG_OK;
         done = (uint16_t)(done + DG_STORE_CHECKED_MAX)) {
        result = dg_store_put(self->store, self->region, (uint16_t)(place + done), &from[done],
                              least_of((uint32_t)n - done));
    }
    return result;
}

int dg_co_end_copy(struct dg_co_copies *self, uint16_t sum)
{
    const uint8_t copy = (uint8_t)(self->found ? 1u - self->newest : 0u);
    uint8_t head[EDS_COPY_HEAD];

    dg_store_le16(head, (uint16_t)(self->found ? (self->number + 1u) % NO_NUMBER : 0));
    dg_store_le16(&head[2], sum);
    return dg_store_put(self->store, self->region, copy_place_of(self, copy), head, sizeof head);
}

/* ------------------------------------------------------------ a node's */

static struct dg_co_copies copies_of(struct dg_co_node *node)
{
    const struct dg_co_file *file = co_file_of(node);

    return dg_co_open_copies(&node->store, (uint8_t)(file->layout.region_count - 1u),
                             file->long_kept);
}

/* Whether the copy in force is what the values are. */
static bool is_copy_saved(struct dg_co_copies *copies, const uint8_t *values)
{
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    bool same = copies->found;

    for (uint16_t at = 0; same && at < copies->size; at = (uint16_t)(at + DG_STORE_CHECKED_MAX)) {
        const uint16_t n = least_of((uint32_t)copies->size - at);
        same = dg_co_read_copy(copies, at, bytes, n) && memcmp(bytes, &values[at], n) == 0;
    }
    return same;
}

void dg_co_save_longs(struct dg_co_node *node)
{
    const uint8_t *values = dg_co_long_bytes(node);

    if (co_file_of(node)->long_kept == 0) {
        return;
    }
    struct dg_co_copies copies = copies_of(node);
    if (!is_copy_saved(&copies, values) &&
        dg_co_write_copy(&copies, 0, values, copies.size) == DG_OK) {
        (void)dg_co_end_copy(&copies, dg_crc16(0, values, copies.size));
    }
}

/* A number that the file would not take has its default. */
void dg_co_load_longs(struct dg_co_node *node)
{
    const struct dg_co_file *file = co_file_of(node);
    uint8_t *values = dg_co_long_bytes(node);

    if (file->long_kept == 0) {
        return;
    }
    struct dg_co_copies copies = copies_of(node);
    if (!dg_co_read_copy(&copies, 0, values, copies.size)) {
        return;
    }
    for (uint16_t i = 0; i < file->long_count; i++) {
        const struct dg_co_long *one = &file->longs[i];
        if (one->kept && !dg_co_long_is_inside(one, &values[one->at + EDS_LENGTH_SIZE])) {
            memcpy(&values[one->at + EDS_LENGTH_SIZE], one->initial, one->n);
        }
    }
}
