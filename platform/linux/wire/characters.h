/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The time and the marks of characters on an asynchronous line. No I/O.
 */
#ifndef DREHGEBER_LINUX_CHARACTERS_H
#define DREHGEBER_LINUX_CHARACTERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/time.h"
#include "uart.h"

/** Longest reply. */
#define LX_REPLY_MAX 135u

/**
 * A reply on its way out. Character n is at the receiver at the end of its stop bit, counted from
 * the start of the reply, so that late wake-ups do not add up.
 */
struct lx_line {
    uint8_t bytes[LX_REPLY_MAX];
    size_t length;
    size_t sent;   /**< characters handed over so far */
    dg_ns start;   /**< falling edge of the first start bit */
    uint32_t baud; /**< data rate */
    uint32_t bits; /**< of a character */
};

/** Begin to send `n` bytes, at most LX_REPLY_MAX; what was still on its way is cut off. */
void lx_line_start(struct lx_line *self, dg_ns now, const uint8_t *bytes, size_t n);

/** The UART setting from now on. */
void lx_line_set(struct lx_line *self, const struct lx_uart *uart);

/** Take the characters that have arrived by `now`. @return how many, from *bytes on */
size_t lx_line_take(struct lx_line *self, dg_ns now, const uint8_t **bytes);

/** Take all characters at once; the line stays busy for their time. */
size_t lx_line_take_all(struct lx_line *self, const uint8_t **bytes);

/** When the next character is over, DG_NEVER when all are taken. */
dg_ns lx_line_next(const struct lx_line *self);

/** Whether the reply is still on the line: what comes in now collides with it. */
bool lx_line_busy(const struct lx_line *self, dg_ns now);

/** The character that began before `at` and has not been taken yet. @return false: there is none */
bool lx_line_on(const struct lx_line *self, dg_ns at, uint8_t *byte);

/** The same reply once more, right behind its end. */
void lx_line_repeat(struct lx_line *self);

/** Cut off what is on its way. */
void lx_line_stop(struct lx_line *self);

/** A received character. */
struct lx_character {
    uint8_t byte;
    bool damaged; /**< parity or framing error, or sent with another setting */
};

/** Characters of a master that are still on their way: two of the longest frames. */
#define LX_INTAKE_MAX ((size_t)2 * LX_REPLY_MAX)

/** A character on its way in. */
struct lx_coming {
    dg_ns end; /**< of its stop bit */
    struct lx_character character;
    uint32_t baud; /**< it is sent at; LX_BAUD_ANY */
    char parity;   /**< likewise; 0: the port cannot tell */
};

/**
 * What a master hands over at once, spread over the time it takes on a line: a character begins
 * when it is handed over, or at the end of the one before. All zero is an idle line.
 */
struct lx_intake {
    struct lx_coming coming[LX_INTAKE_MAX];
    size_t first;
    size_t count;
    dg_ns end; /**< of the last one that was put in */
};

/**
 * A character was handed over at `now` and takes `each`; `end` is filled in.
 * @return false: there are LX_INTAKE_MAX on their way already, it is lost
 */
bool lx_intake_put(struct lx_intake *self, dg_ns now, dg_ns each, const struct lx_coming *coming);

/** End of the character that is over first, DG_NEVER when none is on its way. */
dg_ns lx_intake_next(const struct lx_intake *self);

/** End of the last one, DG_NEVER when none is on its way. */
dg_ns lx_intake_last(const struct lx_intake *self);

/** Take the first one; there has to be one. */
struct lx_coming lx_intake_take(struct lx_intake *self);

/** Decoder of what a tty gives with INPCK|PARMRK: FF 00 c is a damaged c, FF FF an intact FF. */
struct lx_parmrk {
    uint8_t seen; /**< bytes of an escape seen so far, 0..2 */
};

/** @return true when `byte` completes a character, which is in `out` then */
bool lx_parmrk_feed(struct lx_parmrk *self, uint8_t byte, struct lx_character *out);

#endif
