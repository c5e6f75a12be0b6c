/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The marks of characters that a tty gives. No I/O.
 */
#ifndef DREHGEBER_LINUX_CHARACTERS_H
#define DREHGEBER_LINUX_CHARACTERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** A received character. */
struct lx_character {
    uint8_t byte;
    bool damaged; /**< parity or framing error, or sent with another setting */
};

/** Decoder of what a tty gives with INPCK|PARMRK: FF 00 c is a damaged c, FF FF an intact FF. */
struct lx_parmrk {
    uint8_t seen; /**< bytes of an escape seen so far, 0..2 */
};

/** @return true when `byte` completes a character, which is in `out` then */
bool lx_parmrk_feed(struct lx_parmrk *self, uint8_t byte, struct lx_character *out);

#endif
