/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Words that are laid out by a text, a character for each part in the order in which it is sent:
 * "000 P E Y". '0' and '1' are a bit each as it is, blanks are nothing, and what each letter is a
 * protocol says. For models that are texts: an image whose models are all built in does not link
 * this.
 */
#ifndef DREHGEBER_FORM_H
#define DREHGEBER_FORM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest layout, in characters. */
#define DG_FORM_MAX 40u

/** A part. */
struct dg_form_part {
    char letter;
    uint8_t bits;   /**< 1..64 */
    uint64_t value; /**< of so many bits */
};

/** All parts there can be. */
struct dg_form {
    const char *layout;
    struct dg_form_part *parts;
    size_t count;
};

/** A word. */
struct dg_form_word {
    uint64_t bits; /**< right-aligned */
    uint8_t count;
};

/** Whether there is nothing else in the layout, each letter at most once, and 1 to `most` (64) bits
 * in all. */
DG_API bool dg_form_fits(const struct dg_form *self, uint32_t most);

/** Whether the layout has this letter. */
DG_API bool dg_form_has(const char *layout, char letter);

/** The word as far as the first `end`, which is not in it: what a check sum there is about. '\0':
 * all of it. Of a layout that fits. */
DG_API struct dg_form_word dg_form_pack(const struct dg_form *self, char end);

/** Take a word apart: values of those parts that are in it. What stands above it is ignored. */
DG_API void dg_form_unpack(const struct dg_form *self, uint64_t bits);

#ifdef __cplusplus
}
#endif

#endif
