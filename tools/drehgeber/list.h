/* SPDX-License-Identifier: MIT */
/* `drehgeber list` and `drehgeber faults`: what there is, and what can happen to it. */
#ifndef DREHGEBER_TOOL_LIST_H
#define DREHGEBER_TOOL_LIST_H

#include "options.h"

/* Both print their own errors. @return how the program ends, unless stdout fails */
int list_command(const struct options *options);
int faults_command(const struct options *options);

#endif
