/* SPDX-License-Identifier: MIT */
/** A plan without a file, whose settings a test adds. */
#ifndef SUPPORT_PLAN_RIG_H
#define SUPPORT_PLAN_RIG_H

#include "plan.h"

/** One with memory, a shaft and a wire of this kind. */
void plan_rig_begin(struct dg_plan *self, const char *name, const struct dg_plan_wire_kind *kind,
                    const char *where);

/** Give it back, with settings that lx_plan_add_assignment() has added. */
void plan_rig_free(struct dg_plan *self);

#endif
