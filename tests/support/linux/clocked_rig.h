/* SPDX-License-Identifier: MIT */
/** A clocked line without a plan: one encoder on a bus of its own. */
#ifndef TESTS_SUPPORT_CLOCKED_RIG_H
#define TESTS_SUPPORT_CLOCKED_RIG_H

#include "clocked.h"

/** Put `host`, which has its power, behind `line`; the faults of `control` happen to it. `tap` is
 * told the levels. There is one such bus at a time. */
void clocked_rig_connect(struct lx_clocked *line, struct dg_host *host, struct dg_encoder *control,
                         const struct dg_bus_edges_setup *wire, const struct lx_tap *tap);

/** When a master begins. */
#define CLOCKED_RIG_BEGIN DG_S(1)

/** The same behind the cable of `timing`, with the master of `line`. */
void clocked_rig_begin(struct dg_bus_master *master, struct lx_clocked *line, struct dg_host *host,
                       struct dg_encoder *control, const struct dg_plan_timing *timing,
                       const struct lx_tap *tap);

#endif
