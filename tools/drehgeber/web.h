/* SPDX-License-Identifier: MIT */
/* The `web` command: a running drehgeber in a browser. */
#ifndef DREHGEBER_TOOL_WEB_H
#define DREHGEBER_TOOL_WEB_H

#include "options.h"

/* Become drehgeber-web, the program that serves the page of what runs at the address, or at the
   only default address. Prints its own errors; returns, with how the program ends, only then. */
int web_command(const struct options *options);

#endif
