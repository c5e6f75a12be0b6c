/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of an encoder that answers with eleven characters, and how its line behaves.
 */
#ifndef DREHGEBER_LINUX_ELEVEN_SETTINGS_H
#define DREHGEBER_LINUX_ELEVEN_SETTINGS_H

#include "drehgeber/eleven.h"
#include "line_settings.h"
#include "stacks.h"

/** The settings of one encoder. */
struct lx_eleven_settings {
    struct dg_eleven_model encoder;
    struct lx_line_settings line;
};

/** The protocol, as the port knows it. */
extern const struct lx_stack lx_eleven_stack;

#endif
