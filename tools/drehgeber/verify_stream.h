/* SPDX-License-Identifier: MIT */
/* Bytes to and from a real encoder, or the adapter in front of it: a serial port, a
   pseudo-terminal, a TCP port. */
#ifndef DREHGEBER_TOOL_VERIFY_STREAM_H
#define DREHGEBER_TOOL_VERIFY_STREAM_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/time.h"
#include "error.h"
#include "uart.h"

/* The serial port or pseudo-terminal `path` with this setting, or tcp:HOST:PORT. @return the
   descriptor, without blocking, or -1 with `error` */
int verify_stream_open(const char *where, const struct lx_uart *uart, struct lx_error *error);

/* Send it all within a second. @return 0, or -1: it does not take it, or nobody is there */
int verify_stream_send(int fd, const void *bytes, size_t n);

/* What has come by `until` at the latest; the first piece of it. @return its length, 0: nothing,
   -1: nobody is there any more */
long verify_stream_receive(int fd, dg_ns until, void *to, size_t size);

/* Do nothing until then, by lx_real_now(). */
void verify_stream_sleep(dg_ns until);

#endif
