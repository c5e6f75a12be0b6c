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
    {"st",          "",   AT(singleturn_bits), DG_KEY_U8,   0, 1,        1, DG_SSI_FORM_PART_BITS_MAX, NULL, "singleturn bits; 10 to 32 with those of the turns"},
    {"code",        "",   AT(code),            DG_KEY_WORD, 0, 1,        0, DG_SSI_CODE_COUNT - 1, codes, "of the position: gray or binary"},
    {"error_bit",   "",   AT(error_bit),       DG_KEY_WORD, 0, 1,        0, DG_SSI_ERROR_BIT_COUNT - 1, error_bits, "behind the position: none, high or low is an error"},
    {"parity",      "",   AT(parity),          DG_KEY_WORD, 0, 1,        0, DG_SSI_PARITY_COUNT - 1, parities, "last bit of the word: none, even or odd"},
    {"once",        "",   AT(once),            DG_KEY_FLAG, 0, 1,        0,      1, dg_key_no_yes, "the word is sent once and zeros follow"},
    {"monoflop_us", "us", AT(monoflop),        DG_KEY_NS,   0, 1000, US(MONOFLOP_MIN), US(MONOFLOP_MAX), NULL, "silence on the clock that ends a word"},
    {"init_ms",     "ms", AT(init),            DG_KEY_NS,   0, 1000000,  0, 600000, NULL,          "after power-on: data is low"},
};
/* clang-format on */

const struct dg_keys dg_ssi_keys = {rows, DG_COUNT(rows)};
