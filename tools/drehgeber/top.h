/* SPDX-License-Identifier: MIT */
/* The `top` command: a front panel of a running drehgeber in the terminal. */
#ifndef DREHGEBER_TOOL_TOP_H
#define DREHGEBER_TOOL_TOP_H

/* Show what runs at `wanted`, or at the only default address, until q, SIGTERM or SIGINT. Prints
   its own errors, returns how the program ends; the terminal is as before. */
int top_command(const char *wanted);

#endif
