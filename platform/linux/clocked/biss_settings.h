/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of a BiSS encoder.
 */
#ifndef DREHGEBER_LINUX_BISS_SETTINGS_H
#define DREHGEBER_LINUX_BISS_SETTINGS_H

#include "drehgeber/biss.h"
#include "stacks.h"

/** The protocol, as the port knows it; its settings are a struct dg_biss_model. */
extern const struct lx_stack lx_biss_stack;

/** On a simulated wire the master leaves an encoder the time it has of its own.
 * @return 0, or -1 with `error`: one was set */
int lx_biss_own_timeout(const struct dg_plan *plan, const struct dg_plan_encoder *encoder,
                        const struct dg_biss_model *model, struct lx_error *error);

#endif
