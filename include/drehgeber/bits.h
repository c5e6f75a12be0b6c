/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Endian loads and stores, and bounded cursors over byte buffers. A cursor never reads or writes
 * past its end: it remembers that it would have, and the caller asks once at the end.
 */
#ifndef DREHGEBER_BITS_H
#define DREHGEBER_BITS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Two bytes at `p`, which needs no alignment here and below. be = most significant byte first. */
DG_API uint16_t dg_load_be16(const uint8_t *p);
/** Three bytes. */
DG_API uint32_t dg_load_be24(const uint8_t *p);
/** Four bytes. */
DG_API uint32_t dg_load_be32(const uint8_t *p);
/** The store for dg_load_be16(). */
DG_API void dg_store_be16(uint8_t *p, uint16_t value);
/** The store for dg_load_be24(); the upper byte of `value` is left out. */
DG_API void dg_store_be24(uint8_t *p, uint32_t value);
/** The store for dg_load_be32(). */
DG_API void dg_store_be32(uint8_t *p, uint32_t value);

/** le = least significant byte first. In the header, so that frames are built without a call. */
static inline uint16_t dg_load_le16(const uint8_t *p)
{
    return (uint16_t)((uint32_t)p[0] | (uint32_t)p[1] << 8);
}

/** As dg_load_le16(), four bytes. */
static inline uint32_t dg_load_le32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/** The store for dg_load_le16(). */
static inline void dg_store_le16(uint8_t *p, uint16_t value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
}

/** The store for dg_load_le32(). */
static inline void dg_store_le32(uint8_t *p, uint32_t value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
    p[2] = (uint8_t)(value >> 16);
    p[3] = (uint8_t)(value >> 24);
}

/** The same with eight bytes: one store where two of four would be put together byte by byte. */
static inline void dg_store_le64(uint8_t *p, uint64_t value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
    p[2] = (uint8_t)(value >> 16);
    p[3] = (uint8_t)(value >> 24);
    p[4] = (uint8_t)(value >> 32);
    p[5] = (uint8_t)(value >> 40);
    p[6] = (uint8_t)(value >> 48);
    p[7] = (uint8_t)(value >> 56);
}

/** Reads bytes from `at` up to `end`. Lives as long as the buffer. */
struct dg_reader {
    const uint8_t *at;
    const uint8_t *end;
    bool overrun; /**< more was asked for than there was; that read and all after it gave 0 */
};

/** Appends bytes at `at` up to `end`. */
struct dg_writer {
    uint8_t *at;
    uint8_t *end;
    bool overrun; /**< more was appended than fits; that value and all after it were dropped */
};

/** A cursor over `n` bytes. */
DG_API struct dg_reader dg_reader(const uint8_t *bytes, size_t n);
/** Take the next byte. */
DG_API uint8_t dg_read_u8(struct dg_reader *r);
/** Take the next two bytes. */
DG_API uint16_t dg_read_be16(struct dg_reader *r);
/** Take the next four bytes. */
DG_API uint32_t dg_read_be32(struct dg_reader *r);

/** A cursor over `capacity` free bytes. */
DG_API struct dg_writer dg_writer(uint8_t *bytes, size_t capacity);
/** Append a byte. */
DG_API void dg_write_u8(struct dg_writer *w, uint8_t value);
/** Append two bytes. */
DG_API void dg_write_be16(struct dg_writer *w, uint16_t value);
/** Append three bytes; the upper one of `value` is left out. */
DG_API void dg_write_be24(struct dg_writer *w, uint32_t value);
/** Append four bytes. */
DG_API void dg_write_be32(struct dg_writer *w, uint32_t value);
/** Append `n` bytes as they are, all of them or none. */
DG_API void dg_write_bytes(struct dg_writer *w, const uint8_t *bytes, size_t n);

#ifdef __cplusplus
}
#endif

#endif
