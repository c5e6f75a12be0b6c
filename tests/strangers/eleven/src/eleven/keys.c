/* SPDX-License-Identifier: MIT */
/*
 * What can be set of an encoder that answers with eleven characters.
 */
#include "drehgeber/eleven.h"

#define AT(field) offsetof(struct dg_eleven_model, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name         unit  offset        type       places factor min max                  words help */
    {"slot",        "",   AT(slot),     DG_KEY_U8, 0,     1,     0,  DG_ELEVEN_SLOTS - 1, NULL, "which of the encoders on a line it is"},
    {"reaction_us", "us", AT(reaction), DG_KEY_NS, 0,     1000,  0,  1000,                NULL, "from a request to its reply"},
};
/* clang-format on */

const struct dg_keys dg_eleven_keys = {rows, DG_COUNT(rows)};
