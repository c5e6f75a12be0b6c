/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What is right of what can be set of a simulated wire itself: the master's clock and the cable.
 */
#ifndef DREHGEBER_LINUX_SIM_SETTINGS_H
#define DREHGEBER_LINUX_SIM_SETTINGS_H

#include "clocked_wire.h"

/** Whether the settings of its wire suit the encoders of `line`: a master that does not compensate
 * needs a clock that the cable leaves time for, and they one that they take for one frame.
 * @return 0, or -1 with `error` */
int lx_sim_timing_check(const struct lx_bus_setup *setup, const struct lx_clocked *line,
                        struct lx_error *error);

#endif
