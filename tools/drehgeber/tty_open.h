/* SPDX-License-Identifier: MIT */
/* A serial port as a master opens it. */
#ifndef DREHGEBER_TOOL_TTY_OPEN_H
#define DREHGEBER_TOOL_TTY_OPEN_H

#include "uart.h"

/* The serial port or pseudo-terminal `path`, raw, with this setting, what has come in before thrown
   away. @return the descriptor, without blocking, or -1 with errno */
int tty_open(const char *path, const struct lx_uart *uart);

#endif
