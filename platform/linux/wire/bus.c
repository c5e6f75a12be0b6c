/* SPDX-License-Identifier: MIT */
#include "bus.h"

#include <inttypes.h>
#include <stdio.h>

void lx_bus_count(struct dg_scpi *to, const struct lx_count *rows, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        char text[64];
        (void)snprintf(text, sizeof text, "%s=%" PRIu64, rows[i].name, rows[i].value);
        dg_scpi_put_word(to, text);
    }
}
