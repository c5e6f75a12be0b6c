/* SPDX-License-Identifier: MIT */
/**
 * @file
 * RFC 2217, telnet with the COM port option, seen from the port: bytes of a client in, characters,
 * settings and answers out, and what the client hears of a line that others use, too. No I/O: for
 * whatever a host has in the place of a TCP connection. Telnet's binary, suppress go ahead and COM
 * port are done both ways, all other options are declined. Data are eight bits without a meaning
 * from the first byte on, as every client of this option sends them. An object of its own, that an
 * image without it does not carry.
 */
#ifndef DREHGEBER_RFC2217_H
#define DREHGEBER_RFC2217_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Data rates a client can choose. */
#define DG_RFC2217_BAUD_MIN 50u
#define DG_RFC2217_BAUD_MAX 4000000u

/** Longest command of a client that is looked at. */
#define DG_RFC2217_COMMAND_MAX 16u
/** Longest answer to a byte. */
#define DG_RFC2217_ANSWER_MAX 48u
/** Longest text of a character that is told. */
#define DG_RFC2217_TEXT_MAX 10u

/** Groups of SET-CONTROL values (RFC 2217, 3): one of each is in force. */
#define DG_RFC2217_CONTROLS 5u

/** Bits of a line state (RFC 2217, 3). */
enum dg_rfc2217_line {
    DG_RFC2217_PARITY = 4,
    DG_RFC2217_FRAMING = 8,
    DG_RFC2217_BREAK_SEEN = 16,
};

/** The setting of a UART with 8 data bits. */
struct dg_rfc2217_uart {
    uint32_t baud; /**< DG_BAUD_ANY (bus_characters.h): nobody knows, or any is right */
    char parity; /**< 'N', 'E', 'O', 'M', 'S'; 0: likewise; '?': none that goes with 8 data bits */
};

/** A character on its way to clients. */
struct dg_rfc2217_sound {
    struct dg_rfc2217_uart sent; /**< at this setting */
    uint8_t byte;
    uint8_t line; /**< what is wrong with it at any setting: bits of enum dg_rfc2217_line */
};

/** What a byte leads to. */
enum dg_rfc2217_what {
    DG_RFC2217_NOTHING,
    DG_RFC2217_CHARACTER, /**< a character for the line */
    DG_RFC2217_BREAK,     /**< the line is held low for longer than a character */
};

/** Where in telnet's syntax a client is. */
enum dg_rfc2217_state {
    DG_RFC2217_DATA,
    DG_RFC2217_COMMAND,     /**< behind IAC */
    DG_RFC2217_OPTION,      /**< behind WILL, WONT, DO, DONT */
    DG_RFC2217_SUB,         /**< between SB and SE */
    DG_RFC2217_SUB_COMMAND, /**< there, behind IAC */
};

/** A client. All zero is one that has just come. */
struct dg_rfc2217 {
    uint32_t baud;                        /**< data rate; 0: it has not said one */
    char parity;                          /**< 'N', 'O', 'E', 'M', 'S'; 0: likewise */
    uint8_t data_bits;                    /**< 5..8; 0: likewise */
    uint8_t stop_bits;                    /**< as coded: 1, 2, 3 for one and a half; 0: likewise */
    uint8_t control[DG_RFC2217_CONTROLS]; /**< 0: as it was found */
    uint8_t line_mask;
    bool suspended; /**< it wants neither characters nor answers now */
    uint8_t
        enabled[2]; /**< options that the client does, that we do: a bit for each that is known */
    enum dg_rfc2217_state state;
    uint8_t verb;
    uint8_t length; /**< of `command`; more than DG_RFC2217_COMMAND_MAX: too long to count */
    uint8_t command[DG_RFC2217_COMMAND_MAX];
};

/** What came of a byte. */
struct dg_rfc2217_event {
    enum dg_rfc2217_what what;
    uint8_t character;
    size_t length; /**< of the answer */
    uint8_t answer[DG_RFC2217_ANSWER_MAX];
};

/** A byte came in. `found`: what a client that has said nothing is told the setting is. */
DG_API void dg_rfc2217_feed(struct dg_rfc2217 *self, const struct dg_rfc2217_uart *found,
                            uint8_t byte, struct dg_rfc2217_event *event);

/** The setting of the client's own UART, at which it sends and hears. */
DG_API struct dg_rfc2217_uart dg_rfc2217_setting(const struct dg_rfc2217 *self);

/** A character of the line as the client is told, with what was wrong with it before it, if it
 * wants to know. Another data rate leaves nothing of a character; another format its bits, as far
 * as they go. @return the length in `to` */
DG_API size_t dg_rfc2217_print(const struct dg_rfc2217 *self, const struct dg_rfc2217_sound *sound,
                               uint8_t to[DG_RFC2217_TEXT_MAX]);

#ifdef __cplusplus
}
#endif

#endif
