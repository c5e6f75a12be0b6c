/* SPDX-License-Identifier: MIT */
#include "silkit_pack.h"

#include <stdlib.h>
#include <string.h>

#include "drehgeber/bits.h"

#define FIRST_BYTES 256u
#define ID_MAX 0x7FFu
#define REMOTE 0x8000u
#define DATA_MAX 8u

/* --- out --- */

static bool make_pack_room(struct lx_silkit_pack *self, size_t n)
{
    size_t capacity = self->capacity == 0 ? FIRST_BYTES : self->capacity;
    while (capacity < n) {
        capacity *= 2u;
    }
    if (capacity == self->capacity) {
        return true;
    }
    uint8_t *bytes = realloc(self->bytes, capacity);
    if (bytes != NULL) {
        self->bytes = bytes;
        self->capacity = capacity;
    }
    return bytes != NULL;
}

bool lx_silkit_pack_add(struct lx_silkit_pack *self, uint64_t at, const struct dg_can_frame *frame)
{
    const size_t begin = self->count == 0 ? LX_SILKIT_PACK_HEAD : self->length;
    const uint64_t first = self->count == 0 ? at : self->begin;
    const uint8_t dlc = frame->dlc < DATA_MAX ? frame->dlc : DATA_MAX;
    const size_t n = frame->rtr ? 0 : dlc;
    if (self->count == LX_SILKIT_PACK_FRAMES || at < first || at - first > UINT32_MAX ||
        !make_pack_room(self, begin + LX_SILKIT_PACK_FRAME + n)) {
        return false;
    }
    uint8_t *to = self->bytes + begin;
    self->begin = first;
    self->length = begin + LX_SILKIT_PACK_FRAME + n;
    dg_store_le64(self->bytes, first);
    dg_store_le16(self->bytes + 8, ++self->count);
    dg_store_le16(self->bytes + 10, 0);
    dg_store_le32(to, (uint32_t)(at - first));
    dg_store_le16(to + 4, (uint16_t)(frame->id | (frame->rtr ? REMOTE : 0)));
    to[6] = dlc;
    to[7] = 0;
    memcpy(to + LX_SILKIT_PACK_FRAME, frame->data, n);
    return true;
}

void lx_silkit_pack_clear(struct lx_silkit_pack *self)
{
    self->length = 0;
    self->count = 0;
}

void lx_silkit_pack_free(struct lx_silkit_pack *self)
{
    free(self->bytes);
    *self = (struct lx_silkit_pack){.bytes = NULL};
}

/* --- in --- */

/* @return how long the frame at `from` is, of which `n` bytes are there at most; 0: it is none */
static size_t frame_length_of(const uint8_t *from, size_t n)
{
    if (n < LX_SILKIT_PACK_FRAME) {
        return 0;
    }
    const uint16_t id = dg_load_le16(from + 4);
    const size_t length = LX_SILKIT_PACK_FRAME + ((id & REMOTE) != 0 ? 0u : from[6]);
    const bool good = (id & ~REMOTE) <= ID_MAX && from[6] <= DATA_MAX && from[7] == 0;
    return good && length <= n ? length : 0;
}

bool lx_silkit_pack_is_good(const uint8_t *bytes, size_t n)
{
    if (n < LX_SILKIT_PACK_HEAD || dg_load_le16(bytes + 10) != 0) {
        return false;
    }
    const unsigned count = dg_load_le16(bytes + 8);
    size_t at = LX_SILKIT_PACK_HEAD;
    for (unsigned i = 0; i < count; i++) {
        const size_t length = frame_length_of(bytes + at, n - at);
        if (length == 0) {
            return false;
        }
        at += length;
    }
    return at == n;
}

bool lx_silkit_pack_next(const uint8_t *bytes, size_t n, size_t *at, struct dg_can_frame *frame)
{
    if (*at >= n) {
        return false;
    }
    const uint8_t *from = bytes + *at;
    const uint16_t id = dg_load_le16(from + 4);
    const size_t length = frame_length_of(from, n - *at);
    *frame = (struct dg_can_frame){.id = id & ID_MAX, .rtr = (id & REMOTE) != 0, .dlc = from[6]};
    memcpy(frame->data, from + LX_SILKIT_PACK_FRAME, length - LX_SILKIT_PACK_FRAME);
    *at += length;
    return true;
}
