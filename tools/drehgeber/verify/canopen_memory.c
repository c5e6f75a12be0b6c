/* SPDX-License-Identifier: MIT */
#include "canopen_bench.h"

#include <stdlib.h>

/* Region and offset are words 1 and 2; -1 when `length` bytes are not there. */
static int find_bytes_at(const struct dg_store_layout *layout, char **words, size_t length,
                         unsigned long *offset)
{
    int region = dg_store_find(layout, words[1]);

    *offset = strtoul(words[2], NULL, 0);
    return region >= 0 && *offset + length <= layout->regions[region].size ? region : -1;
}

bool canopen_damage(struct cf_memory *nvm, const struct dg_store_layout *layout, char **words,
                    size_t n, struct cf_report *report)
{
    unsigned long offset = 0;
    int region = n >= 3 ? find_bytes_at(layout, words, 1, &offset) : -1;
    unsigned long mask = n == 4 ? strtoul(words[3], NULL, 16) : 0x01;

    if (region < 0) {
        return cf_fail(report, "damage REGION OFFSET [MASK]");
    }
    offset += dg_store_address(layout, (uint8_t)region);
    nvm->bytes[offset] ^= (uint8_t)mask;
    return true;
}

bool canopen_stored(struct cf_memory *nvm, const struct dg_store_layout *layout, char **words,
                    size_t n, struct cf_report *report)
{
    unsigned long offset = 0;
    int region = n >= 4 ? find_bytes_at(layout, words, n - 3, &offset) : -1;
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    struct dg_store store;

    if (region < 0) {
        return cf_fail(report, "stored REGION OFFSET BYTES");
    }
    uint16_t size = layout->regions[region].size;
    if (dg_store_mount(&store, layout, cf_memory_port(nvm)) != DG_OK ||
        dg_store_read(&store, (uint8_t)region, 0, bytes, size) != DG_OK) {
        return cf_fail(report, "stored: the memory cannot be read");
    }
    for (size_t i = 3; i < n; i++) {
        bytes[offset + i - 3] = (uint8_t)strtoul(words[i], NULL, 16);
    }
    return dg_store_put(&store, (uint8_t)region, 0, bytes, size) == DG_OK ||
           cf_fail(report, "stored: the memory cannot be written");
}
