/* SPDX-License-Identifier: MIT */
/* The `verify` command: a real encoder against the clauses that are known of its kind. */
#ifndef DREHGEBER_TOOL_VERIFY_H
#define DREHGEBER_TOOL_VERIFY_H

#include "options.h"

/* Where the clauses are, if it is set. */
#define VERIFY_FOLDER "DREHGEBER_CLAUSES"

/* Ask the encoder at options->wire. Prints its own errors. @return how the program ends */
int verify_command(const struct options *options);

#endif
