/* SPDX-License-Identifier: MIT */
/* What --help says: of everything, of a command, of a command and a model. */
#ifndef DREHGEBER_TOOL_HELP_H
#define DREHGEBER_TOOL_HELP_H

#include "options.h"

/* On stdout. */
void help_print(const struct options *options);

#endif
