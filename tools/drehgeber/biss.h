/* SPDX-License-Identifier: MIT */
/* The `biss` command, and `run` of a BiSS encoder. */
#ifndef DREHGEBER_TOOL_BISS_H
#define DREHGEBER_TOOL_BISS_H

#include "options.h"

/* Do what options->words say, over a simulated wire. Prints its own errors, returns how the program
   ends. */
int biss_command(const struct options *options);

/* Be that encoder, on GPIO lines or in front of a simulated master in real time, until SIGINT or
   SIGTERM. */
int biss_run(const struct options *options);

#endif
