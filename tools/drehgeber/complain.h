/* SPDX-License-Identifier: MIT */
/* Errors as the user of a command line reads them: with the options that are wrong. */
#ifndef DREHGEBER_TOOL_COMPLAIN_H
#define DREHGEBER_TOOL_COMPLAIN_H

#include "error.h"

/* One line on stderr. @return `status` */
int complain(const struct lx_error *error, int status);

/* That line, without the name of the program. */
struct lx_words complaint(const struct lx_error *error);

#endif
