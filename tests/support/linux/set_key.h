/* SPDX-License-Identifier: MIT */
/** Settings of an encoder without a plan. */
#ifndef SUPPORT_SET_KEY_H
#define SUPPORT_SET_KEY_H

#include "stacks.h"

/** Apply "KEY=VALUE" as a plan would. @return 0 or -1 with `error` */
int set_key(const struct dg_device *device, void *settings, struct dg_world *world,
            const char *assignment, struct lx_error *error);

#endif
