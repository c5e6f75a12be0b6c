/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for what goes over a wire in words: a wire, and the line that was told last.
 */
#ifndef TESTS_SUPPORT_WORDS_RIG_H
#define TESTS_SUPPORT_WORDS_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/words.h"

/** What any words of this library remember fits into so many bytes. */
#define WORDS_RIG_MEMORY 4096u

struct words_rig {
    struct dg_words_wire wire;
    unsigned count; /**< lines so far */
    dg_ns at;       /**< of the last one; likewise the others */
    bool ours;
    enum dg_severity severity;
    const char *clause;
    char text[DG_WORDS_MAX];
    union {
        max_align_t align;
        unsigned char bytes[WORDS_RIG_MEMORY];
    } memory;
};

/** A wire of which nothing is known yet; `words` NULL: its protocol has none. Not to be moved. */
void words_rig_init(struct words_rig *self, const struct dg_words *words);

/** Bytes of a text in hexadecimal, with blanks between them. @return how many */
size_t words_rig_hex(const char *hex, uint8_t *bytes);

#endif
