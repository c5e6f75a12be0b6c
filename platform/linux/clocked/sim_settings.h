/* SPDX-License-Identifier: MIT */
/**
 * @file
 * --set KEY=VALUE of a simulated wire itself: the master's clock and the cable.
 */
#ifndef DREHGEBER_LINUX_SIM_SETTINGS_H
#define DREHGEBER_LINUX_SIM_SETTINGS_H

#include <stdbool.h>
#include <stdio.h>

#include "clocked_wire.h"
#include "plan.h"

/** The keys, NULL behind the last. */
extern const char *const lx_sim_keys[];

/** 1 MHz and no delay. */
void lx_sim_settings_init(struct lx_clocked_timing *self);

/** Whether the key of "key=value" is one of them. */
bool lx_sim_settings_has(const char *assignment);

/** Apply "key=value" with one of the keys. @return 0, or -1 with one line that names what would be
 * right */
int lx_sim_settings_set(struct lx_clocked_timing *self, const char *assignment,
                        struct lx_error *error);

/** Those of a wire of a plan. @return 0, or -1 with one line in `error` that names its place */
int lx_sim_settings_plan(struct lx_clocked_timing *self, const struct lx_plan *plan,
                         const struct lx_plan_wire *wire, struct lx_error *error);

/** The keys with ranges and what they are; for --help. */
void lx_sim_settings_help(FILE *to);

#endif
