/* SPDX-License-Identifier: MIT */
/* INTERBUS encoders: `run` with them, and `map`. */
#ifndef DREHGEBER_TOOL_INTERBUS_H
#define DREHGEBER_TOOL_INTERBUS_H

#include "options.h"

/* Whether the command line is about a ring of INTERBUS encoders. */
bool is_interbus(const struct options *options);

/* Be that ring until SIGINT or SIGTERM. Prints its own errors, returns how the program ends. */
int run_interbus(const struct options *options);

/* Print the Modbus register map. Prints its own errors, returns how the program ends. */
int print_map(const struct options *options);

#endif
