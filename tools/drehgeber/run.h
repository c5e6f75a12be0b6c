/* SPDX-License-Identifier: MIT */
/* The `run` command. */
#ifndef DREHGEBER_TOOL_RUN_H
#define DREHGEBER_TOOL_RUN_H

#include "complain.h"
#include "options.h"

/* How the program ends. */
enum {
    EXIT_OK = 0,
    EXIT_OTHER = 1, /* anything but the user's words */
    EXIT_USAGE = 2, /* the command line, a rig file */
};

/* Be that encoder, that ring, or that rig until SIGINT or SIGTERM. Prints its own errors, returns
   how the program ends. */
int run_rig(const struct options *options);

#endif
