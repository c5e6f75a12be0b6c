/* SPDX-License-Identifier: MIT */
/*
 * The medium; numbers are least significant byte first, except for the CRC-16:
 *
 *    0  header    "dge1" | layout id, 4 | size of the layout, 4; FFFFFFFFh: being formatted
 *   12  copy of the header
 *   24  journal   length, 2 | its complement, 2 | CRC-32 over these four bytes and the changes, 4
 *   32  changes   region, 1 | 00h | offset, 2 | n, 2 | n bytes | next change ...
 *       regions   in table order, a checked one followed by its CRC-16, high byte first
 *
 * A checked region is changed as a whole, so its change needs no offset; its CRC-16 stands there.
 *
 * When the power fails, the next mount finds in the journal and makes of it:
 *
 *   stage ... stage | length, CRC-32 | sync   | apply        | sync | clear
 *   idle            | idle or torn or whole   | whole        | whole or torn or idle
 *   old             | old     old     new     | new, redone  | new     new     new
 *
 * Clearing needs no sync: until the next commit's sync a surviving journal only repeats what is in
 * place already, and the bytes staged over it break its sum.
 *
 * The size in the header tells how many regions the image has: layouts only grow, so an older image
 * ends where some later region of today's table begins. Growing it:
 *
 *   new regions ... | sync | header | sync  | copy    | sync
 *   old             | old  | old    | new, its copy repaired
 *
 * A header torn in between is older, newer or none at all, and beside it stands a whole one: of two
 * the one that knows more regions is right, as those were durable before either was written.
 *
 * Formatting puts a mark in place of the headers, which says that there is no image under it:
 *
 *   mark | sync | copy of it | sync   | regions ...  | sync | header      | sync | copy | sync
 *   old  | old  | old or unfinished   | unfinished   |      | or new      | new  | new
 */
#include "drehgeber/store.h"

#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/crc.h"
#include "drehgeber/text.h"

#define HEADER_SIZE 12u
#define HEADERS_SIZE (2u * HEADER_SIZE)
#define JOURNAL HEADERS_SIZE
#define JOURNAL_HEAD_SIZE 8u
#define JOURNAL_LENGTH_SIZE 4u /* length and complement */
#define JOURNAL_NO_LENGTH 0xFFFFFFFFu
#define CHANGES (JOURNAL + JOURNAL_HEAD_SIZE)
#define CHANGE_HEAD_SIZE 6u
#define SUM_SIZE 2u
#define SUM_SEED 0xFFFFu
#define ERASED 0xFFu
#define CHUNK 32u

enum journal_state { JOURNAL_IDLE, JOURNAL_WHOLE, JOURNAL_TORN };

static int nvm_read(const struct dg_nvm *nvm, uint32_t address, void *to, size_t n)
{
    return nvm->ops->read(nvm->ctx, address, to, n);
}

static int nvm_write(const struct dg_nvm *nvm, uint32_t address, const void *from, size_t n)
{
    return nvm->ops->write(nvm->ctx, address, from, n);
}

static int nvm_sync(const struct dg_nvm *nvm)
{
    return nvm->ops->sync == NULL ? DG_OK : nvm->ops->sync(nvm->ctx);
}

static bool are_same_bytes(const uint8_t *a, const uint8_t *b, size_t n)
{
    while (n > 0 && *a == *b) {
        a++;
        b++;
        n--;
    }
    return n == 0;
}

static size_t chunk(uint32_t n)
{
    return n < CHUNK ? n : CHUNK;
}

static int nvm_erase(const struct dg_nvm *nvm, uint32_t address, uint32_t n)
{
    uint8_t bytes[CHUNK];
    memset(bytes, ERASED, sizeof bytes);
    for (uint32_t done = 0; done < n; done += CHUNK) {
        if (nvm_write(nvm, address + done, bytes, chunk(n - done)) != DG_OK) {
            return DG_ERR_IO;
        }
    }
    return DG_OK;
}

static int nvm_copy(const struct dg_nvm *nvm, uint32_t from, uint32_t to, uint32_t n)
{
    uint8_t bytes[CHUNK];
    for (uint32_t done = 0; done < n; done += CHUNK) {
        if (nvm_read(nvm, from + done, bytes, chunk(n - done)) != DG_OK ||
            nvm_write(nvm, to + done, bytes, chunk(n - done)) != DG_OK) {
            return DG_ERR_IO;
        }
    }
    return DG_OK;
}

static bool inside(const struct dg_store *self, uint8_t region, uint16_t offset, uint16_t n)
{
    return region < self->region_count &&
           (uint32_t)offset + n <= self->layout->regions[region].size;
}

static bool checked(const struct dg_store_layout *layout, uint8_t region)
{
    return region < layout->region_count && layout->regions[region].check == DG_STORE_CHECKED;
}

static bool stageable(const struct dg_store *self, uint8_t region, uint16_t offset, uint16_t n)
{
    return inside(self, region, offset, n) &&
           (!checked(self->layout, region) || n == self->layout->regions[region].size);
}

/* Header. */

/* The header of an image with the first `regions` regions; 0: the mark of one that is being
   formatted. */
static void make_header(const struct dg_store_layout *layout, uint8_t regions, uint8_t *header)
{
    static const uint8_t magic[4] = {'d', 'g', 'e', '1'};
    memcpy(header, magic, sizeof magic);
    dg_store_le32(header + 4, layout->id);
    dg_store_le32(header + 8, regions == 0 ? UINT32_MAX : dg_store_address(layout, regions));
}

/* One after the other: of two, one is always whole. */
static int write_headers(const struct dg_store_layout *layout, const struct dg_nvm *nvm,
                         uint8_t regions)
{
    uint8_t header[HEADER_SIZE];
    make_header(layout, regions, header);
    if (nvm_write(nvm, 0, header, HEADER_SIZE) != DG_OK || nvm_sync(nvm) != DG_OK ||
        nvm_write(nvm, HEADER_SIZE, header, HEADER_SIZE) != DG_OK) {
        return DG_ERR_IO;
    }
    return nvm_sync(nvm);
}

/* How many regions the image under `header` has; 0: of another layout, or not intact. An image has
   exactly one header, so being the right one and being intact are the same. */
static uint8_t regions_under(const struct dg_store_layout *layout, const uint8_t *header)
{
    uint8_t right[HEADER_SIZE];
    uint8_t regions = layout->region_count;
    while (regions > 0) {
        make_header(layout, regions, right);
        if (are_same_bytes(header, right, HEADER_SIZE)) {
            break;
        }
        regions--;
    }
    return regions;
}

static bool has_mark(const struct dg_store_layout *layout, const uint8_t *headers)
{
    uint8_t mark[HEADER_SIZE];
    make_header(layout, 0, mark);
    return are_same_bytes(headers, mark, HEADER_SIZE) ||
           are_same_bytes(headers + HEADER_SIZE, mark, HEADER_SIZE);
}

static int no_header(const struct dg_store_layout *layout, const uint8_t *headers)
{
    uint32_t i = 0;
    if (has_mark(layout, headers)) {
        return DG_ERR_BLANK;
    }
    while (i < HEADERS_SIZE && headers[i] == ERASED) {
        i++;
    }
    return i == HEADERS_SIZE ? DG_ERR_BLANK : DG_ERR_FOREIGN;
}

static int check_header(struct dg_store *self)
{
    uint8_t right[HEADER_SIZE];
    uint8_t found[HEADERS_SIZE];
    if (nvm_read(&self->nvm, 0, found, sizeof found) != DG_OK) {
        return DG_ERR_IO;
    }
    const uint8_t first = regions_under(self->layout, found);
    const uint8_t copy = regions_under(self->layout, found + HEADER_SIZE);
    if (first == 0 && copy == 0) {
        return no_header(self->layout, found);
    }
    self->region_count = first > copy ? first : copy;
    if (first == copy) {
        return DG_OK;
    }
    /* Only the damaged one is written: whatever becomes of it, the other stays. */
    make_header(self->layout, self->region_count, right);
    if (nvm_write(&self->nvm, first > copy ? HEADER_SIZE : 0, right, HEADER_SIZE) != DG_OK) {
        return DG_ERR_IO;
    }
    self->repairs++;
    return nvm_sync(&self->nvm);
}

/* Journal. */

/* The head that makes the first `length` bytes of changes a whole journal. */
static int make_journal_head(const struct dg_nvm *nvm, uint16_t length, uint8_t *head)
{
    uint8_t bytes[CHUNK];
    dg_store_le16(head, length);
    dg_store_le16(head + 2, (uint16_t)~length);
    uint32_t sum = dg_crc32(0, head, JOURNAL_LENGTH_SIZE);
    for (uint32_t done = 0; done < length; done += CHUNK) {
        if (nvm_read(nvm, CHANGES + done, bytes, chunk(length - done)) != DG_OK) {
            return DG_ERR_IO;
        }
        sum = dg_crc32(sum, bytes, chunk(length - done));
    }
    dg_store_le32(head + JOURNAL_LENGTH_SIZE, sum);
    return DG_OK;
}

/* Whether there is a journal, see enum journal_state, and how long a whole one is. */
static int inspect_journal(const struct dg_store *self, uint16_t *length)
{
    uint8_t found[JOURNAL_HEAD_SIZE];
    uint8_t right[JOURNAL_HEAD_SIZE];
    if (nvm_read(&self->nvm, JOURNAL, found, sizeof found) != DG_OK) {
        return DG_ERR_IO;
    }
    /* No length has itself for its complement: whatever follows, this is never a whole one. */
    if (dg_load_le32(found) == JOURNAL_NO_LENGTH) {
        return JOURNAL_IDLE;
    }
    *length = dg_load_le16(found);
    if (*length > self->layout->journal_size) {
        return JOURNAL_TORN;
    }
    if (make_journal_head(&self->nvm, *length, right) != DG_OK) {
        return DG_ERR_IO;
    }
    return are_same_bytes(found, right, sizeof found) ? JOURNAL_WHOLE : JOURNAL_TORN;
}

/* Put the changes in place, in order; `regions` collects the ones written as a whole. */
static int apply_journal(const struct dg_store *self, uint16_t length, uint32_t *regions)
{
    const struct dg_store_layout *layout = self->layout;
    const uint32_t end = CHANGES + length;
    uint32_t at = CHANGES;
    while (at + CHANGE_HEAD_SIZE <= end) {
        uint8_t head[CHANGE_HEAD_SIZE];
        if (nvm_read(&self->nvm, at, head, sizeof head) != DG_OK) {
            return DG_ERR_IO;
        }
        const uint8_t region = head[0];
        const uint16_t n = dg_load_le16(head + 4);
        const bool whole = checked(layout, region);
        const uint16_t offset = whole ? 0 : dg_load_le16(head + 2);
        const uint32_t to = dg_store_address(layout, region) + offset;
        at += CHANGE_HEAD_SIZE;
        /* Stage lets nothing else in: a forged image must not write outside of its region. */
        if (n > end - at || !stageable(self, region, offset, n)) {
            break;
        }
        if (nvm_copy(&self->nvm, at, to, n) != DG_OK ||
            (whole && nvm_write(&self->nvm, to + n, head + 2, SUM_SIZE) != DG_OK)) {
            return DG_ERR_IO;
        }
        *regions |= (uint32_t)whole << region;
        at += n;
    }
    return DG_OK;
}

/*
 * Complete a whole journal, and clear it. The sync before: what a crashed process left may be
 * readable and not yet durable, and a journal has to outlive the first change in place.
 */
static int complete_journal(struct dg_store *self, uint16_t length)
{
    uint32_t regions = 0;
    if (nvm_sync(&self->nvm) != DG_OK || apply_journal(self, length, &regions) != DG_OK ||
        nvm_sync(&self->nvm) != DG_OK) {
        return DG_ERR_IO;
    }
    self->damaged &= ~regions;
    return nvm_erase(&self->nvm, JOURNAL, JOURNAL_HEAD_SIZE);
}

/* Drop a torn journal, durably: staging the same bytes again would make it whole without a
   commit. */
static int drop_journal(const struct dg_store *self)
{
    return nvm_erase(&self->nvm, JOURNAL, JOURNAL_HEAD_SIZE) == DG_OK ? nvm_sync(&self->nvm)
                                                                      : DG_ERR_IO;
}

/* Leave the journal idle, whatever is there. Returns enum journal_state as found, or DG_ERR_IO. */
static int settle_journal(struct dg_store *self)
{
    uint16_t length = 0;
    const int state = inspect_journal(self, &length);
    if ((state == JOURNAL_WHOLE && complete_journal(self, length) != DG_OK) ||
        (state == JOURNAL_TORN && drop_journal(self) != DG_OK)) {
        return DG_ERR_IO;
    }
    self->unapplied = state < 0;
    return state;
}

/* What an earlier call left open comes first. */
static int settle_open(struct dg_store *self)
{
    const int result = self->unapplied ? settle_journal(self) : DG_OK;
    return result < 0 ? result : DG_OK;
}

static int stage_change(struct dg_store *self, const uint8_t *head, const void *from, uint16_t n)
{
    const uint32_t at = CHANGES + self->journal_length;
    if (CHANGE_HEAD_SIZE + n > (uint32_t)self->layout->journal_size - self->journal_length) {
        return DG_ERR_SPACE;
    }
    if (settle_open(self) != DG_OK || nvm_write(&self->nvm, at, head, CHANGE_HEAD_SIZE) != DG_OK ||
        nvm_write(&self->nvm, at + CHANGE_HEAD_SIZE, from, n) != DG_OK) {
        return DG_ERR_IO;
    }
    self->journal_length = (uint16_t)(self->journal_length + CHANGE_HEAD_SIZE + n);
    return DG_OK;
}

static int commit_journal(struct dg_store *self)
{
    uint8_t head[JOURNAL_HEAD_SIZE];
    if (make_journal_head(&self->nvm, self->journal_length, head) != DG_OK) {
        return DG_ERR_IO;
    }
    /* From here on the journal may be on the medium, also when the write says that it failed. When
       it succeeds the journal is whole, and is not read back: 310 of 43h's 2285 instructions. */
    self->unapplied = true;
    if (nvm_write(&self->nvm, JOURNAL, head, sizeof head) != DG_OK ||
        complete_journal(self, self->journal_length) != DG_OK) {
        return DG_ERR_IO;
    }
    self->unapplied = false;
    self->journal_length = 0;
    return DG_OK;
}

/* Regions. */

/* A CRC without reflection or final XOR over content and its own sum is 0. */
static int check_region(struct dg_store *self, uint8_t region)
{
    uint8_t bytes[CHUNK];
    uint16_t sum = SUM_SEED;
    const uint32_t n = self->layout->regions[region].size + SUM_SIZE;
    const uint32_t address = dg_store_address(self->layout, region);
    for (uint32_t done = 0; done < n; done += CHUNK) {
        if (nvm_read(&self->nvm, address + done, bytes, chunk(n - done)) != DG_OK) {
            return DG_ERR_IO;
        }
        sum = dg_crc16(sum, bytes, chunk(n - done));
    }
    self->damaged |= (uint32_t)(sum != 0) << region;
    return DG_OK;
}

static int check_regions(struct dg_store *self)
{
    int result = DG_OK;
    for (uint8_t region = 0; result == DG_OK && region < self->region_count; region++) {
        if (checked(self->layout, region)) {
            result = check_region(self, region);
        }
    }
    return result;
}

/* Delivery state of a region on erased memory. */
static int format_region(const struct dg_store_region *region, const struct dg_nvm *nvm,
                         uint32_t address, const void *ctx)
{
    uint8_t bytes[DG_STORE_CHECKED_MAX + SUM_SIZE];
    const size_t n = region->size;
    const bool whole = region->check == DG_STORE_CHECKED;
    if (!whole && region->defaults == NULL) {
        return DG_OK;
    }
    if (n > DG_STORE_CHECKED_MAX) {
        return DG_ERR_ARGUMENT;
    }
    memset(bytes, ERASED, sizeof bytes);
    if (region->defaults != NULL) {
        region->defaults(ctx, bytes);
    }
    dg_store_be16(bytes + n, dg_crc16(SUM_SEED, bytes, n));
    return nvm_write(nvm, address, bytes, whole ? n + SUM_SIZE : n);
}

/* Delivery state of region `first` and all behind it, whatever was there. */
static int format_regions(const struct dg_store_layout *layout, const struct dg_nvm *nvm,
                          uint8_t first, const void *ctx)
{
    const uint32_t address = dg_store_address(layout, first);
    int result = nvm_erase(nvm, address, dg_store_size(layout) - address);
    for (uint8_t i = first; result == DG_OK && i < layout->region_count; i++) {
        result = format_region(&layout->regions[i], nvm, dg_store_address(layout, i), ctx);
    }
    return result;
}

/* Public. */

static int count_failure(struct dg_store *self, int result)
{
    if (result == DG_ERR_IO) {
        self->failures++;
    }
    return result;
}

uint32_t dg_store_size(const struct dg_store_layout *layout)
{
    return dg_store_address(layout, layout->region_count);
}

uint32_t dg_store_address(const struct dg_store_layout *layout, uint8_t region)
{
    uint32_t address = CHANGES + layout->journal_size;
    for (uint8_t i = 0; i < region && i < layout->region_count; i++) {
        address += layout->regions[i].size + (checked(layout, i) ? SUM_SIZE : 0u);
    }
    return address;
}

int dg_store_find(const struct dg_store_layout *layout, const char *name)
{
    for (uint8_t region = 0; region < layout->region_count; region++) {
        if (dg_text_same(layout->regions[region].name, name, SIZE_MAX, NULL)) {
            return region;
        }
    }
    return DG_ERR_ARGUMENT;
}

/* Marks go first and headers come last: no half image is ever under a header. */
int dg_store_format(const struct dg_store_layout *layout, struct dg_nvm nvm, const void *ctx)
{
    if (write_headers(layout, &nvm, 0) != DG_OK ||
        nvm_erase(&nvm, JOURNAL, dg_store_address(layout, 0) - JOURNAL) != DG_OK) {
        return DG_ERR_IO;
    }
    const int result = format_regions(layout, &nvm, 0, ctx);
    if (result != DG_OK) {
        return result;
    }
    return nvm_sync(&nvm) == DG_OK ? write_headers(layout, &nvm, layout->region_count) : DG_ERR_IO;
}

bool dg_store_unfinished(const struct dg_store_layout *layout, struct dg_nvm nvm)
{
    struct dg_store store;
    uint8_t found[HEADERS_SIZE];
    return dg_store_mount(&store, layout, nvm) == DG_ERR_BLANK &&
           nvm_read(&nvm, 0, found, sizeof found) == DG_OK && has_mark(layout, found);
}

int dg_store_mount(struct dg_store *self, const struct dg_store_layout *layout, struct dg_nvm nvm)
{
    *self = (struct dg_store){
        .layout = layout, .nvm = nvm, .region_count = layout->region_count, .unapplied = true};
    int result = check_header(self);
    if (result == DG_OK) {
        result = settle_journal(self);
    }
    if (result >= 0) {
        self->replays = result == JOURNAL_WHOLE;
        result = check_regions(self);
    }
    if (result == DG_OK && self->region_count < layout->region_count) {
        result = DG_ERR_OLDER;
    }
    return count_failure(self, result);
}

int dg_store_grow(struct dg_store *self, const void *ctx)
{
    const struct dg_store_layout *layout = self->layout;
    int result = format_regions(layout, &self->nvm, self->region_count, ctx);
    if (result == DG_OK) {
        result = nvm_sync(&self->nvm);
    }
    if (result == DG_OK) {
        result = write_headers(layout, &self->nvm, layout->region_count);
    }
    if (result == DG_OK) {
        self->region_count = layout->region_count;
    }
    return count_failure(self, result);
}

bool dg_store_damaged(const struct dg_store *self, uint8_t region)
{
    return region < self->layout->region_count && (self->damaged >> region & 1u) != 0;
}

int dg_store_read(struct dg_store *self, uint8_t region, uint16_t offset, void *to, uint16_t n)
{
    if (!inside(self, region, offset, n)) {
        return DG_ERR_ARGUMENT;
    }
    int result = settle_open(self);
    if (result == DG_OK && n > 0) {
        result = nvm_read(&self->nvm, dg_store_address(self->layout, region) + offset, to, n);
    }
    return count_failure(self, result);
}

void dg_store_begin(struct dg_store *self)
{
    self->journal_length = 0;
    self->failed = DG_OK;
}

int dg_store_stage(struct dg_store *self, uint8_t region, uint16_t offset, const void *from,
                   uint16_t n)
{
    uint8_t head[CHANGE_HEAD_SIZE] = {region};
    int result = DG_OK;
    if (self->failed != DG_OK) {
        return count_failure(self, self->failed);
    }
    if (!stageable(self, region, offset, n)) {
        result = DG_ERR_ARGUMENT;
    } else if (n > 0) {
        const bool whole = checked(self->layout, region);
        if (whole) {
            dg_store_be16(head + 2, dg_crc16(SUM_SEED, from, n));
        } else {
            dg_store_le16(head + 2, offset);
        }
        dg_store_le16(head + 4, n);
        result = stage_change(self, head, from, n);
    }
    self->failed = (int8_t)result;
    return count_failure(self, result);
}

int dg_store_commit(struct dg_store *self)
{
    int result = self->failed != DG_OK ? self->failed : settle_open(self);
    if (result == DG_OK && self->journal_length > 0) {
        result = commit_journal(self);
    }
    return count_failure(self, result);
}

int dg_store_put(struct dg_store *self, uint8_t region, uint16_t offset, const void *from,
                 uint16_t n)
{
    dg_store_begin(self);
    const int result = dg_store_stage(self, region, offset, from, n);
    return result == DG_OK ? dg_store_commit(self) : result;
}
