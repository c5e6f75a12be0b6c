/* SPDX-License-Identifier: MIT */
/* The `run` command. */
#ifndef DREHGEBER_TOOL_RUN_H
#define DREHGEBER_TOOL_RUN_H

#include "options.h"

/* How the program ends. */
enum {
    EXIT_OK = 0,
    EXIT_OTHER = 1, /* anything but the user's words */
    EXIT_USAGE = 2, /* the command line */
};

/* Be that encoder until SIGINT or SIGTERM. Prints its own errors, returns how the program ends. */
int run_encoder(const struct options *options);

#endif
