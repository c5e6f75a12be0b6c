/* SPDX-License-Identifier: MIT */
/*
 * What can be set of an encoder with SSI.
 */
#include "drehgeber/ssi.h"

static const char *const codes[] = {"gray", "binary"};
static const char *const error_bits[] = {"none", "high", "low"};
static const char *const parities[] = {"none", "even", "odd"};

#define AT(field) offsetof(struct dg_ssi_model, field)
#define US(limit) (DG_SSI_##limit##_NS / DG_US(1))

/* clang-format off */
static const struct dg_key rows[] = {
    /* name         unit  offset               type        places factor min    max  words           help */
    {"mt",          "",   AT(multiturn_bits),  DG_KEY_U8,   0, 1,        0, DG_SSI_FORM_PART_BITS_MAX, NULL, "multiturn bits"},
    {"st",          "",   AT(singleturn_bits), DG_KEY_U8,   0, 1,        1, DG_SSI_FORM_PART_BITS_MAX, NULL, "singleturn bits; together with mt 10 to 32"},
    {"code",        "",   AT(code),            DG_KEY_WORD, 0, 1,        0, DG_SSI_CODE_COUNT - 1, codes, "code of the position"},
    {"error_bit",   "",   AT(error_bit),       DG_KEY_WORD, 0, 1,        0, DG_SSI_ERROR_BIT_COUNT - 1, error_bits, "error bit after the position: none, or the level that means an error"},
    {"parity",      "",   AT(parity),          DG_KEY_WORD, 0, 1,        0, DG_SSI_PARITY_COUNT - 1, parities, "parity bit at the end of the word"},
    {"once",        "",   AT(once),            DG_KEY_FLAG, 0, 1,        0,      1, dg_key_no_yes, "1: the encoder sends the word once, and zeros after it"},
    {"monoflop_us", "us", AT(monoflop),        DG_KEY_NS,   0, 1000, US(MONOFLOP_MIN), US(MONOFLOP_MAX), NULL, "a pause of the clock of this length ends a word"},
    {"init_ms",     "ms", AT(init),            DG_KEY_NS,   0, 1000000,  0, 600000, NULL,          "time after power-on during which data is low"},
};
/* clang-format on */

const struct dg_keys dg_ssi_keys = {rows, DG_COUNT(rows)};
