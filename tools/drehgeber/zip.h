/* SPDX-License-Identifier: MIT */
/* An archive with nothing compressed, as the ZIP format has it (APPNOTE 6.3, chapter 4). */
#ifndef DREHGEBER_TOOL_ZIP_H
#define DREHGEBER_TOOL_ZIP_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct zip_entry {
    char name[200];
    uint32_t at, size, sum;
};

struct zip {
    FILE *to;
    struct zip_entry *entries; /* owned */
    size_t count;
    uint32_t at; /* bytes so far */
    bool bad;    /* something could not be written, or no memory */
};

/* Below 4 GB in all, and 65535 entries. Errors stay in `bad`. */
void zip_add(struct zip *self, const char *name, const void *bytes, size_t n);
/* The list at the end. @return 0, or -1 if anything was bad; nothing of `self` is in use then */
int zip_end(struct zip *self);

#endif
