/* SPDX-License-Identifier: MIT */
/* What an EDS file says of a CANopen device, as clauses and rows. */
#ifndef DREHGEBER_TOOL_VERIFY_EDS_H
#define DREHGEBER_TOOL_VERIFY_EDS_H

#include "error.h"
#include "options.h"
#include "rows.h"

/* The clauses of options->eds that options->words ask for, for the node options->node. 0, or -1
   with `error`. */
int verify_eds_load(const struct options *options, struct cf_suite *suite, struct lx_error *error);

/* --node as a number, 63 if it was not given. 0, or -1 with `error`. */
int verify_eds_node(const char *node, uint8_t *id, struct lx_error *error);

#endif
