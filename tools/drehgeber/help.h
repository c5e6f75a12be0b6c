/* SPDX-License-Identifier: MIT */
/*
 * What --help says: of everything, of a command, of a command and a model. Manual pages and what
 * shells complete are made of the same texts (tools/manual).
 */
#ifndef DREHGEBER_TOOL_HELP_H
#define DREHGEBER_TOOL_HELP_H

#include <stdio.h>

#include "options.h"

/* Texts: paragraphs with an empty line between them; lines that begin with blanks stand for
   themselves. */
extern const char help_intro[];
extern const char help_motion[];
extern const char help_time[]; /* KEY=VALUE of verify */
extern const char help_exit[];

/* More than the row of a command says, such a text. */
const char *help_about(const char *command);

/* KEY=VALUE of a stack's encoders, a line each, and of the wires that carry it and that the command
   `row` has, NULL: any: behind a line " of --can:". With `device` its own defaults are told. */
void help_keys(const struct command_row *row, const struct lx_stack *stack,
               const struct dg_device *device, FILE *to);

/* KEY=VALUE of what encoders of the stack sense; NULL: of any. */
void help_senses(const struct lx_stack *stack, FILE *to);

/* On stdout. */
void help_print(const struct options *options);

#endif
