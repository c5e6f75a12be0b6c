/* SPDX-License-Identifier: MIT */
#include "drehgeber/bits.h"

#include <string.h>

uint16_t dg_load_be16(const uint8_t *p)
{
    return (uint16_t)(((uint32_t)p[0] << 8) | p[1]);
}

uint32_t dg_load_be24(const uint8_t *p)
{
    return ((uint32_t)p[0] << 16) | ((uint32_t)p[1] << 8) | p[2];
}

uint32_t dg_load_be32(const uint8_t *p)
{
    return ((uint32_t)p[0] << 24) | dg_load_be24(p + 1);
}

void dg_store_be16(uint8_t *p, uint16_t value)
{
    p[0] = (uint8_t)(value >> 8);
    p[1] = (uint8_t)value;
}

void dg_store_be24(uint8_t *p, uint32_t value)
{
    p[0] = (uint8_t)(value >> 16);
    p[1] = (uint8_t)(value >> 8);
    p[2] = (uint8_t)value;
}

void dg_store_be32(uint8_t *p, uint32_t value)
{
    p[0] = (uint8_t)(value >> 24);
    dg_store_be24(p + 1, value);
}

/**
 * The next `n` bytes, or NULL when there are fewer. What is left is given up then, so that a
 * value after a missing one is never read from the missing one's bytes.
 */
static const uint8_t *take_bytes(struct dg_reader *r, size_t n)
{
    const uint8_t *taken = r->at;

    if ((size_t)(r->end - r->at) < n) {
        r->overrun = true;
        r->at = r->end;
        return NULL;
    }
    r->at += n;
    return taken;
}

struct dg_reader dg_reader(const uint8_t *bytes, size_t n)
{
    /* An empty buffer may be NULL, and NULL + 0 is undefined in C. */
    return (struct dg_reader){.at = bytes, .end = n > 0 ? bytes + n : bytes, .overrun = false};
}

uint8_t dg_read_u8(struct dg_reader *r)
{
    const uint8_t *p = take_bytes(r, 1);

    return p != NULL ? p[0] : 0;
}

uint16_t dg_read_be16(struct dg_reader *r)
{
    const uint8_t *p = take_bytes(r, 2);

    return p != NULL ? dg_load_be16(p) : 0;
}

uint32_t dg_read_be32(struct dg_reader *r)
{
    const uint8_t *p = take_bytes(r, 4);

    return p != NULL ? dg_load_be32(p) : 0;
}

struct dg_writer dg_writer(uint8_t *bytes, size_t capacity)
{
    return (struct dg_writer){
        .at = bytes, .end = capacity > 0 ? bytes + capacity : bytes, .overrun = false};
}

void dg_write_u8(struct dg_writer *w, uint8_t value)
{
    dg_write_bytes(w, &value, 1);
}

void dg_write_be16(struct dg_writer *w, uint16_t value)
{
    uint8_t bytes[2];

    dg_store_be16(bytes, value);
    dg_write_bytes(w, bytes, sizeof bytes);
}

void dg_write_be24(struct dg_writer *w, uint32_t value)
{
    uint8_t bytes[3];

    dg_store_be24(bytes, value);
    dg_write_bytes(w, bytes, sizeof bytes);
}

void dg_write_be32(struct dg_writer *w, uint32_t value)
{
    uint8_t bytes[4];

    dg_store_be32(bytes, value);
    dg_write_bytes(w, bytes, sizeof bytes);
}

void dg_write_bytes(struct dg_writer *w, const uint8_t *bytes, size_t n)
{
    if (n == 0) {
        return; /* memcpy wants valid pointers even for nothing */
    }
    /* After one loss everything is lost: a shorter value must not slip into the gap. */
    if (w->overrun || (size_t)(w->end - w->at) < n) {
        w->overrun = true;
        return;
    }
    memcpy(w->at, bytes, n);
    w->at += n;
}
