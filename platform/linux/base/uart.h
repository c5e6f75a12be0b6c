/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An asynchronous line: 8 data bits, one stop bit.
 */
#ifndef DREHGEBER_LINUX_UART_H
#define DREHGEBER_LINUX_UART_H

#include <stdint.h>

/** Its setting. */
struct lx_uart {
    uint32_t baud; /**< data rate */
    char parity;   /**< 'N', 'E' or 'O' */
};

/** Bits of a character: start bit, data, parity if there is one, stop bit. */
static inline uint32_t lx_character_bits(char parity)
{
    return parity == 'N' ? 10u : 11u;
}

#endif
