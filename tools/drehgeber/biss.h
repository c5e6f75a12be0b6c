/* SPDX-License-Identifier: MIT */
/* The `biss` command. */
#ifndef DREHGEBER_TOOL_BISS_H
#define DREHGEBER_TOOL_BISS_H

#include "options.h"

/* Do what options->words say, over a simulated wire. Prints its own errors, returns how the program
   ends. */
int biss_command(const struct options *options);

#endif
