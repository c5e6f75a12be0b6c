/* SPDX-License-Identifier: MIT */
/* The `fmu` command. */
#ifndef DREHGEBER_TOOL_FMU_FILE_H
#define DREHGEBER_TOOL_FMU_FILE_H

#include "options.h"

/* Write the FMU of a model or a rig file. Prints its own errors, returns how the program ends. */
int fmu_command(const struct options *options);

#endif
