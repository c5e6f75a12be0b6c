/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Who may use the control plane: the words behind a control address, and a guard that looks at the
 * first bytes of every line a TCP client sends.
 *
 * A browser can be made to send requests to any port of this machine. It cannot choose how they
 * begin: a line that begins like HTTP or TLS ends the connection before anything is done, and so
 * does whatever follows a first line that is no SCPI.
 */
#ifndef DREHGEBER_LINUX_ACCESS_H
#define DREHGEBER_LINUX_ACCESS_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "say.h"

/** Longest address: "unix:" and a path, "tcp:" HOST:PORT. */
#define LX_ACCESS_WHERE_MAX 300u
/** Longest token; the shortest has LX_ACCESS_TOKEN_MIN characters. */
#define LX_ACCESS_TOKEN_MAX 128u
#define LX_ACCESS_TOKEN_MIN 16u

/** A control address: ADDRESS[,open][,token=FILE]. */
struct lx_access {
    char where[LX_ACCESS_WHERE_MAX]; /**< unix:PATH or tcp:HOST:PORT */
    bool tcp;
    bool open;                 /**< tcp: beyond loopback, too */
    char token_file[PATH_MAX]; /**< "": no token */
};

/** Take a control address apart. @return 0, or -1 with one line in `error` */
int lx_access_parse(const char *text, struct lx_access *out, struct lx_error *error);

/**
 * The token that stands in a file: one line of LX_ACCESS_TOKEN_MIN..LX_ACCESS_TOKEN_MAX printable
 * characters without quotes. The file must be the user's own and closed to others (mode 0600).
 * @return 0, or -1 with one line in `error`
 */
int lx_access_token(const char *path, char to[LX_ACCESS_TOKEN_MAX + 1u], struct lx_error *error);

/** Longest line that names a token, with its end and a zero. */
#define LX_ACCESS_GREETING_MAX (LX_ACCESS_TOKEN_MAX + 16u)

/**
 * A connection to a control address, which blocks, and the line to begin it with ("" without a
 * token).
 * @return the descriptor, or -1 with one line in `error`
 */
int lx_access_connect(const char *text, char greeting[LX_ACCESS_GREETING_MAX],
                      struct lx_error *error);

/** What is to be done with a line. */
enum lx_guard_verdict {
    LX_GUARD_PASS, /**< it is for the session */
    LX_GUARD_SKIP, /**< it was for the guard */
    LX_GUARD_TELL, /**< no token, or not the right one: say so, then close */
    LX_GUARD_CLOSE /**< nobody who speaks SCPI says this */
};

/** First bytes of a connection that lx_begins_foreign() needs at most. */
#define LX_FOREIGN_MAX 9u

/** Whether a connection that begins with these bytes is one of HTTP or TLS: a method and a path, or
 * the header of a handshake. No request to an encoder or an adapter begins so. */
bool lx_begins_foreign(const uint8_t *bytes, size_t n);

/** The guard of one connection. Zero, but for the settings: at its beginning. */
struct lx_guard {
    bool tcp;          /**< setting; without it every line passes */
    const char *token; /**< setting; NULL: none is asked for */
    bool named;        /**< the right token has come */
    bool begun;        /**< a line has come */
    bool strange;      /**< ... and it was no SCPI */
    bool inside;       /**< the piece before was the beginning of this line */
};

/**
 * Look at a line, or at a piece of one that is too long, before the session gets it.
 * @param n with its end, if it has one
 */
enum lx_guard_verdict lx_guard_line(struct lx_guard *self, const char *line, size_t n);

#endif
