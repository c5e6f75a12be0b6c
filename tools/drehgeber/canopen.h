/* SPDX-License-Identifier: MIT */
/* What the command line says about CANopen encoders. */
#ifndef DREHGEBER_TOOL_CANOPEN_H
#define DREHGEBER_TOOL_CANOPEN_H

#include "can_nodes.h"
#include "options.h"

/* --node and --serial become figures in `setup`. 0, or -1 with one line in `error`. */
int canopen_understand(const struct options *options, struct lx_can_nodes_setup *setup,
                       struct lx_error *error);

/* `assignment` mt_bits=12 or 16 makes `model`, an f3668, the one with that many turns. 1: it was
   that key; 0: it is another one; -1 with one line in `error`. */
int canopen_set(struct dg_cia406_model *model, const char *assignment, struct lx_error *error);

#endif
