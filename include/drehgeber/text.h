/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Texts without a C library.
 */
#ifndef DREHGEBER_TEXT_H
#define DREHGEBER_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A text that grows in somebody's buffer; what does not fit is cut off. */
struct dg_text {
    char *to; /**< always terminated */
    size_t size;
    size_t length;
};

/** An empty one in `size` bytes, at least 1. */
DG_API struct dg_text dg_text_in(char *to, size_t size);

/** Characters of a text, `max` at most: there need be no more of it. */
DG_API size_t dg_text_length(const char *text, size_t max);

/** Append. */
DG_API void dg_text_add(struct dg_text *self, const char *text);

/** Append `n` characters, fewer if the text ends before. */
DG_API void dg_text_add_n(struct dg_text *self, const char *text, size_t n);

/** Longest number in decimal: 20 digits, sign, decimal point. */
#define DG_TEXT_DIGITS_MAX 22u

/** A number in decimal, not terminated, with `places` (0..18) behind its point. @return its length
 */
DG_API size_t dg_text_digits(char to[DG_TEXT_DIGITS_MAX], uint64_t magnitude, bool negative,
                             unsigned places);

/** Append a number in decimal. */
DG_API void dg_text_add_number(struct dg_text *self, int64_t value);

/** Append the last `digits` (1..16) hexadecimal digits of a number, in capital letters. */
DG_API void dg_text_add_hex(struct dg_text *self, uint64_t value, unsigned digits);

/** What a character counts as. */
typedef char dg_text_fold(char c);

/** Small letters as capital ones. */
DG_API char dg_text_upper(char c);

/** Whether two texts are the same, in their first `n` characters.
 * @param n SIZE_MAX: all
 * @param fold NULL: each character counts as itself */
DG_API bool dg_text_same(const char *a, const char *b, size_t n, dg_text_fold *fold);

/** Longest text that dg_text_edits() compares. */
#define DG_TEXT_EDITS_MAX 16u

/** How many characters have to change, be added, be left out or exchange their places to make a
 * word of `text` (the distance of Damerau and Levenshtein, where no place is changed twice);
 * capital and small letters count as the same.
 * @param length of the word, at most 1000
 * @param n of the text; ~0u is the answer for more than DG_TEXT_EDITS_MAX
 * @param brief small letters of the word may be left out for nothing: SCPI's long forms */
DG_API unsigned dg_text_edits(const char *word, size_t length, const char *text, size_t n,
                              bool brief);

#ifdef __cplusplus
}
#endif

#endif
