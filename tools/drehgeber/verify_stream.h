/* SPDX-License-Identifier: MIT */
/* Bytes to and from a real encoder, or the adapter in front of it: a serial port, a
   pseudo-terminal, a TCP port, a serial port behind one (RFC 2217), a simulation. */
#ifndef DREHGEBER_TOOL_VERIFY_STREAM_H
#define DREHGEBER_TOOL_VERIFY_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/time.h"
#include "error.h"
#include "options.h"
#include "uart.h"

struct verify_silkit;

struct verify_stream {
    int fd; /* without blocking; -1: closed */
    bool network;
    struct verify_silkit *silkit; /* owned; in its place, with its time; NULL: there is none */
    /* RFC 2217 */
    bool telnet;
    uint8_t state; /* where in the syntax of telnet the other end is */
    uint8_t verb;  /* of the command that it has begun */
};

/* The serial port or pseudo-terminal `where` with this setting, tcp:HOST:PORT, or
   rfc2217:HOST:PORT, which is told the setting. 0, or -1 with `error` */
int verify_stream_open(struct verify_stream *self, const char *where, const struct lx_uart *uart,
                       struct lx_error *error);

/* The simulation that the options name. 0, or -1 with `error` */
int verify_stream_join(struct verify_stream *self, const struct options *options,
                       struct lx_error *error);

/* Nobody has answered: whether it is known why; then `error` says it. */
bool verify_stream_explain(const struct verify_stream *self, struct lx_error *error);

/* Send it all within a second. @return 0, or -1: it does not take it, or nobody is there */
int verify_stream_send(struct verify_stream *self, const void *bytes, size_t n);

/* What has come by `until` at the latest; the first piece of it. @return its length, 0: nothing,
   -1: nobody is there any more */
long verify_stream_receive(struct verify_stream *self, dg_ns until, void *to, size_t size);

void verify_stream_close(struct verify_stream *self);

/* Do nothing until then, by lx_real_now(). */
void verify_stream_sleep(dg_ns until);

/* Likewise by lx_now(), which may be the time of this stream; NULL is fine. */
void verify_stream_wait(struct verify_stream *self, dg_ns until);

#endif
