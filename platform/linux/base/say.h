/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a port tells its user: one line per event on stderr. A line that stderr does not take at
 * once is left out; how many is said with the next one.
 */
#ifndef DREHGEBER_LINUX_SAY_H
#define DREHGEBER_LINUX_SAY_H

#include <stdbool.h>

#include "error.h"

/** Longest line, with its zero; the rest is cut off. */
#define LX_LINE_MAX 1100u

/** Who is told what. */
struct lx_say {
    bool quiet; /**< only complaints, no notes */
};

/** A line about something the user may want to know; silent when quiet. */
void lx_note(const struct lx_say *say, const char *format, ...);

/** A line about something that does not work. */
void lx_complain(const char *format, ...);

/** A line that was asked for, as it is. */
void lx_print(const char *format, ...);

#endif
