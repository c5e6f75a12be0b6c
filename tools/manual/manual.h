/* SPDX-License-Identifier: MIT */
/*
 * Manual pages, shell completion and tables of pages, of the tables that the command line itself
 * works with. On stdout.
 */
#ifndef DREHGEBER_MANUAL_H
#define DREHGEBER_MANUAL_H

#include <argp.h>
#include <stdbool.h>

#include "options.h"

/* The page of a command; NULL: that of the program. @return false: there is no such command */
bool manual_page(const char *command);

/* A table of a page. @return false: there is no such table */
bool manual_table(const char *name);

void manual_bash(void);
void manual_zsh(void);

/* --- what both shells need --- */

/* Whether this is the first row of its command. */
bool manual_is_first(const struct command_row *row);

/* "-q" of "--quiet", or 0. */
char manual_short(const struct argp_option *option);

/* Whether a MODEL, or a rig file, stands behind a command. */
bool manual_takes_model(const struct command_row *row);
bool manual_takes_rig(const struct command_row *row);

/* Names of the models that a command takes, or of those of a stack, with a blank in front of each.
 */
void manual_models(const struct dg_stack *stack);

/* Names of what --set sets of a stack's encoders and their wires, likewise. */
void manual_keys(const struct lx_stack *stack);

#endif
