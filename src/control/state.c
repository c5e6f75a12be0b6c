/* SPDX-License-Identifier: MIT */
/*
 * STATe?: key=value parts. Values have neither ',' nor ';', lists have '/', nothing is '-'.
 */
#include "control_private.h"

void control_state_begin(struct dg_scpi *to, const char *key)
{
    dg_scpi_begin(to);
    dg_scpi_append(to, key);
    dg_scpi_append(to, "=");
}

void control_state_word(struct dg_scpi *to, const char *key, const char *word)
{
    control_state_begin(to, key);
    dg_scpi_append(to, word);
}

void control_state_number(struct dg_scpi *to, const char *key, uint64_t value)
{
    control_state_begin(to, key);
    dg_scpi_append_number(to, (int64_t)value, 0);
}

void control_state_hex(struct dg_scpi *to, const char *key, uint64_t value, unsigned digits)
{
    control_state_begin(to, key);
    dg_scpi_append_hex(to, value, digits);
}

void control_state_common(struct dg_scpi *to, bool powered, const char *mode, uint64_t position)
{
    control_state_number(to, "power", powered ? 1 : 0);
    control_state_word(to, "mode", mode);
    if (powered) {
        control_state_number(to, "position", position);
    } else {
        control_state_word(to, "position", "-");
    }
}

void control_state_item(struct dg_scpi *to, bool *first, uint64_t value, unsigned digits)
{
    if (!*first) {
        dg_scpi_append(to, "/");
    }
    *first = false;
    dg_scpi_append_hex(to, value, digits);
}
