/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of a simulated wire itself: the master's clock and the cable.
 */
#ifndef DREHGEBER_LINUX_SIM_SETTINGS_H
#define DREHGEBER_LINUX_SIM_SETTINGS_H

#include "clocked_wire.h"
#include "error.h"
#include "key.h"
#include "plan.h"

/** As usual, with the settings of `wire`. A master that does not compensate needs a clock that the
 * cable leaves time for, and the encoders of `line` one that they take for one frame.
 * @return 0, or -1 with `error` */
int lx_sim_timing_set(const struct dg_plan *plan, const struct dg_plan_wire *wire,
                      const struct lx_clocked *line, struct dg_plan_timing *timing,
                      struct lx_error *error);

#endif
