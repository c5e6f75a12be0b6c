/* SPDX-License-Identifier: MIT */
/**
 * @file
 * RFC 2217, telnet with the COM port option, seen from the port: bytes of a client in, characters,
 * settings and answers out. No I/O. Telnet's binary, suppress go ahead and COM port are done both
 * ways, all other options are declined. Data are eight bits without a meaning from the first byte
 * on, as every client of this option sends them.
 */
#ifndef DREHGEBER_LINUX_RFC2217_H
#define DREHGEBER_LINUX_RFC2217_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "uart.h"

/** Data rates a client can choose. */
#define LX_RFC2217_BAUD_MIN 50u
#define LX_RFC2217_BAUD_MAX 4000000u

/** Longest command of a client that is looked at. */
#define LX_RFC2217_COMMAND_MAX 16u
/** Longest answer to a byte. */
#define LX_RFC2217_ANSWER_MAX 48u
/** Longest text of a character that is told. */
#define LX_RFC2217_TEXT_MAX 10u

/** Groups of SET-CONTROL values (RFC 2217, 3): one of each is in force. */
#define LX_RFC2217_CONTROLS 5u

/** Bits of a line state (RFC 2217, 3). */
enum lx_rfc2217_line {
    LX_RFC2217_PARITY = 4,
    LX_RFC2217_FRAMING = 8,
    LX_RFC2217_BREAK_SEEN = 16,
};

/** What a byte leads to. */
enum lx_rfc2217_what {
    LX_RFC2217_NOTHING,
    LX_RFC2217_CHARACTER, /**< a character for the line */
    LX_RFC2217_BREAK,     /**< the line is held low for longer than a character */
};

/** Where in telnet's syntax a client is. */
enum lx_rfc2217_state {
    LX_RFC2217_DATA,
    LX_RFC2217_COMMAND,     /**< behind IAC */
    LX_RFC2217_OPTION,      /**< behind WILL, WONT, DO, DONT */
    LX_RFC2217_SUB,         /**< between SB and SE */
    LX_RFC2217_SUB_COMMAND, /**< there, behind IAC */
};

/** A client. All zero is one that has just come. */
struct lx_rfc2217 {
    uint32_t baud;                        /**< data rate; 0: it has not said one */
    char parity;                          /**< 'N', 'O', 'E', 'M', 'S'; 0: likewise */
    uint8_t data_bits;                    /**< 5..8; 0: likewise */
    uint8_t stop_bits;                    /**< as coded: 1, 2, 3 for one and a half; 0: likewise */
    uint8_t control[LX_RFC2217_CONTROLS]; /**< 0: as it was found */
    uint8_t line_mask;
    bool suspended; /**< it wants neither characters nor answers now */
    uint8_t
        enabled[2]; /**< options that the client does, that we do: a bit for each that is known */
    enum lx_rfc2217_state state;
    uint8_t verb;
    uint8_t length; /**< of `command`; more than LX_RFC2217_COMMAND_MAX: too long to count */
    uint8_t command[LX_RFC2217_COMMAND_MAX];
};

/** What came of a byte. */
struct lx_rfc2217_event {
    enum lx_rfc2217_what what;
    uint8_t character;
    size_t length; /**< of the answer */
    uint8_t answer[LX_RFC2217_ANSWER_MAX];
};

/** A byte came in. `found`: what a client that has said nothing is told the setting is. */
void lx_rfc2217_feed(struct lx_rfc2217 *self, const struct lx_uart *found, uint8_t byte,
                     struct lx_rfc2217_event *event);

/** A character of the line as the client is told, with what was wrong with it (bits of enum
 * lx_rfc2217_line) before it, if it wants to know. @return the length in `to` */
size_t lx_rfc2217_print(const struct lx_rfc2217 *self, uint8_t character, uint8_t line,
                        uint8_t to[LX_RFC2217_TEXT_MAX]);

#endif
