/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of a simulated wire itself: the master's clock and the cable.
 */
#ifndef DREHGEBER_LINUX_SIM_SETTINGS_H
#define DREHGEBER_LINUX_SIM_SETTINGS_H

#include "clocked_wire.h"
#include "key.h"

/** Its keys; offsets count from a struct lx_clocked_timing. */
extern const struct lx_keys lx_sim_keys;

/** 1 MHz and no delay. */
extern const struct lx_clocked_timing lx_sim_timing;

#endif
