/* SPDX-License-Identifier: MIT */
#ifndef DREHGEBER_TOOL_MODEL_EDS_C_H
#define DREHGEBER_TOOL_MODEL_EDS_C_H

#include "drehgeber/cia406.h"

/* The file that a model is made of; NULL: it is of none. */
const struct dg_cia406_file *model_eds_of(const struct dg_device *device);

/* Whether C can have all of it. @return EXIT_OK, else how the program ends, and why was said */
int model_eds_check(const struct dg_cia406_file *self, const char *path);

/* It as C on stdout: all but the dg_device, whose model is SYMBOL_file.model. */
void model_eds_put(const struct dg_cia406_file *self, const char *symbol);

/* A literal of C. In model_c.c. */
void model_put_text(const char *text);

#endif
