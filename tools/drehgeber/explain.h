/* SPDX-License-Identifier: MIT */
/*
 * The `explain` command: what went over a wire, of a recording of a real conversation. A reader
 * makes events of a file; messages are made of those and said in words; with --against a model is
 * asked the same.
 */
#ifndef DREHGEBER_TOOL_EXPLAIN_H
#define DREHGEBER_TOOL_EXPLAIN_H

#include "options.h"

/* Print what is in options->capture. Prints its own errors. @return how the program ends */
int explain_command(const struct options *options);

#endif
