/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What fuzz targets share: an input that is eaten byte by byte, and what has to hold.
 */
#ifndef TESTS_SUPPORT_FUZZ_INPUT_H
#define TESTS_SUPPORT_FUZZ_INPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "drehgeber/bits.h"

/** What libFuzzer calls. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n);

/** What is left of the input. */
struct fuzz_input {
    const uint8_t *at;
    const uint8_t *end;
};

/** An invariant. */
static inline void fuzz_must(bool holds)
{
    if (!holds) {
        abort();
    }
}

/** The next byte; 0 behind the end. */
static inline uint8_t fuzz_take(struct fuzz_input *self)
{
    return self->at < self->end ? *self->at++ : 0;
}

/** The next four, the least significant one first. */
static inline uint32_t fuzz_take32(struct fuzz_input *self)
{
    uint8_t bytes[4];

    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = fuzz_take(self);
    }
    return dg_load_le32(bytes);
}

#endif
