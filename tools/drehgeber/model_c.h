/* SPDX-License-Identifier: MIT */
#ifndef DREHGEBER_TOOL_MODEL_C_H
#define DREHGEBER_TOOL_MODEL_C_H

#include "options.h"

/* `drehgeber model`: a model as C, for a program that has no files. @return how the program ends */
int model_command(const struct options *options);

#endif
