/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder that answers with eleven characters, on this port.
 */
#ifndef DREHGEBER_LINUX_ELEVEN_SETTINGS_H
#define DREHGEBER_LINUX_ELEVEN_SETTINGS_H

#include "drehgeber/eleven.h"
#include "stacks.h"

/** The protocol, as the port knows it. */
extern const struct lx_stack lx_eleven_stack;

#endif
