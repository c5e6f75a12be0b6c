/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Signals that ask a program to end.
 */
#ifndef DREHGEBER_LINUX_ENDING_H
#define DREHGEBER_LINUX_ENDING_H

#include <signal.h>
#include <stdbool.h>

/** Those of the user, a script, a service manager and a closed terminal; without what is ignored,
 * as nohup starts a program, and a shell what goes to the background. */
void lx_ending_signals(sigset_t *set);

/** Whether one of them, blocked, waits to be read. */
bool lx_ending_asked(void);

#endif
