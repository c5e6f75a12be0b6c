/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Texts without a C library.
 */
#ifndef DREHGEBER_TEXT_H
#define DREHGEBER_TEXT_H

#include <stdbool.h>
#include <stddef.h>

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

/** Append. */
DG_API void dg_text_add(struct dg_text *self, const char *text);

/** Append `n` characters, fewer if the text ends before. */
DG_API void dg_text_add_n(struct dg_text *self, const char *text, size_t n);

/** What a character counts as. */
typedef char dg_text_fold(char c);

/** Small letters as capital ones. */
DG_API char dg_text_upper(char c);

/** Whether two texts are the same, in their first `n` characters.
 * @param n SIZE_MAX: all
 * @param fold NULL: each character counts as itself */
DG_API bool dg_text_same(const char *a, const char *b, size_t n, dg_text_fold *fold);

#ifdef __cplusplus
}
#endif

#endif
