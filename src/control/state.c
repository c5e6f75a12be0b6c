/* SPDX-License-Identifier: MIT */
/*
 * STATe?: key=value parts. Values have neither ',' nor ';', lists have '/', nothing is '-'.
 */
#include "control_private.h"

void dg_state_begin(struct dg_scpi *to, const char *key)
{
    dg_scpi_begin(to);
    dg_scpi_append(to, key);
    dg_scpi_append(to, "=");
}

void dg_state_word(struct dg_scpi *to, const char *key, const char *word)
{
    dg_state_begin(to, key);
    dg_scpi_append(to, word);
}

void dg_state_number(struct dg_scpi *to, const char *key, uint64_t value)
{
    dg_state_begin(to, key);
    dg_scpi_append_number(to, (int64_t)value, 0);
}

void dg_state_hex(struct dg_scpi *to, const char *key, uint64_t value, unsigned digits)
{
    dg_state_begin(to, key);
    dg_scpi_append_hex(to, value, digits);
}

void dg_state_item(struct dg_scpi *to, bool *first, uint64_t value, unsigned digits)
{
    if (!*first) {
        dg_scpi_append(to, "/");
    }
    *first = false;
    dg_scpi_append_hex(to, value, digits);
}

void dg_state_end(struct dg_scpi *to, bool first)
{
    if (first) {
        dg_scpi_append(to, "-");
    }
}
