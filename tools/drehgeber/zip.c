/* SPDX-License-Identifier: MIT */
/*
 * Why not a library: the command would need it wherever it runs, and more with it. Of Debian 12
 * that is libminizip with zlib, libzip with three more, libarchive with seven. libminizip would
 * leave about 35 of these 88 lines, as it has to be told how to write to a stream, which date, and
 * not to compress. Nothing is compressed here: an FMU is written once, and read where it was
 * written.
 */
#include "zip.h"

#include <stdlib.h>
#include <string.h>

/* CRC-32 of ISO 3309, bit by bit: an archive is made once. */
static uint32_t sum_of(const uint8_t *bytes, size_t n)
{
    uint32_t sum = UINT32_MAX;
    for (size_t i = 0; i < n; i++) {
        sum ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            sum = sum >> 1 ^ ((sum & 1u) != 0 ? 0xEDB88320u : 0u);
        }
    }
    return ~sum;
}

static void put_bytes(struct zip *self, const void *bytes, size_t n)
{
    self->bad = self->bad || fwrite(bytes, 1, n, self->to) != n;
    self->at += (uint32_t)n;
}

static void put_number(struct zip *self, uint32_t value, unsigned bytes)
{
    uint8_t text[4];
    for (unsigned i = 0; i < bytes; i++) {
        text[i] = (uint8_t)(value >> 8 * i);
    }
    put_bytes(self, text, bytes);
}

/* What local headers and the list have in common. Every file is of 1980-01-01, for archives that
   are the same every time. */
static void put_entry(struct zip *self, const struct zip_entry *entry)
{
    put_number(self, 10, 2); /* version that is needed */
    put_number(self, 0, 2);
    put_number(self, 0, 2); /* stored */
    put_number(self, 0, 2);
    put_number(self, 1 << 5 | 1, 2);
    put_number(self, entry->sum, 4);
    put_number(self, entry->size, 4);
    put_number(self, entry->size, 4);
    put_number(self, (uint32_t)strlen(entry->name), 2);
    put_number(self, 0, 2);
}

void zip_add(struct zip *self, const char *name, const void *bytes, size_t n)
{
    struct zip_entry *more = realloc(self->entries, (self->count + 1) * sizeof *more);
    self->entries = more != NULL ? more : self->entries;
    if (more == NULL || strlen(name) >= sizeof more->name) {
        self->bad = true;
        return;
    }
    struct zip_entry *entry = &more[self->count++];
    *entry = (struct zip_entry){.at = self->at, .size = (uint32_t)n};
    entry->sum = sum_of(bytes, n);
    memcpy(entry->name, name, strlen(name) + 1);
    put_number(self, 0x04034B50u, 4);
    put_entry(self, entry);
    put_bytes(self, name, strlen(name));
    put_bytes(self, bytes, n);
}

int zip_end(struct zip *self)
{
    const uint32_t at = self->at;
    for (size_t i = 0; i < self->count; i++) {
        const struct zip_entry *entry = &self->entries[i];
        put_number(self, 0x02014B50u, 4);
        put_number(self, 3 << 8 | 10, 2); /* made on Unix */
        put_entry(self, entry);
        put_number(self, 0, 2);
        put_number(self, 0, 2);
        put_number(self, 0, 2);
        put_number(self, UINT32_C(0100644) << 16, 4);
        put_number(self, entry->at, 4);
        put_bytes(self, entry->name, strlen(entry->name));
    }
    const uint32_t end = self->at;
    put_number(self, 0x06054B50u, 4);
    put_number(self, 0, 4);
    put_number(self, (uint32_t)self->count, 2);
    put_number(self, (uint32_t)self->count, 2);
    put_number(self, end - at, 4);
    put_number(self, at, 4);
    put_number(self, 0, 2);
    free(self->entries);
    self->entries = NULL;
    return self->bad ? -1 : 0;
}
