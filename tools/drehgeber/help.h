/* SPDX-License-Identifier: MIT */
/* What --help says: of everything, of a command, of a command and a model. */
#ifndef DREHGEBER_TOOL_HELP_H
#define DREHGEBER_TOOL_HELP_H

#include "options.h"

/* The models, a line each. */
void help_models(const char *indent);

/* On stdout. */
void help_print(const struct options *options);

#endif
