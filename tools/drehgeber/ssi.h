/* SPDX-License-Identifier: MIT */
/* The `ssi` command. */
#ifndef DREHGEBER_TOOL_SSI_H
#define DREHGEBER_TOOL_SSI_H

#include "options.h"

/* Do what options->words say, over a simulated wire. Prints its own errors, returns how the program
   ends. */
int ssi_command(const struct options *options);

#endif
