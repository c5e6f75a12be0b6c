/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What fuzz targets share: an input that is eaten byte by byte, and what has to hold.
 */
#ifndef TESTS_SUPPORT_FUZZ_INPUT_H
#define TESTS_SUPPORT_FUZZ_INPUT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

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

#endif
