/* SPDX-License-Identifier: MIT */
/* The `ctl` command: SCPI to a running drehgeber. */
#ifndef DREHGEBER_TOOL_CTL_H
#define DREHGEBER_TOOL_CTL_H

#include <stddef.h>

#include "say.h"

/* Where a running drehgeber listens: `wanted`, or the only one at the default addresses.
   @return 0, or -1 with one line in `error` */
int ctl_find(const char *wanted, char *to, size_t size, struct lx_error *error);

/* Where to, and how long it may say nothing; NULL: as the user has not said. */
struct ctl_wanted {
    const char *address;
    const char *timeout; /* a span: "60S" */
};

/* Send each word as a line, without words what comes from stdin; print the answers. Prints its own
   errors and the instrument's, returns how the program ends. */
int ctl_command(const struct ctl_wanted *wanted, char *const *words, size_t count);

#endif
