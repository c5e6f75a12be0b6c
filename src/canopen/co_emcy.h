/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Emergencies: causes, error register, history, the reaction to them.
 */
#ifndef DREHGEBER_CO_EMCY_H
#define DREHGEBER_CO_EMCY_H

#include "canopen_private.h"

void dg_co_emcy_start(struct dg_co_node *self);
dg_ns dg_co_emcy_step(struct dg_co_node *self);
/** What 1029h says for a class of errors. */
void dg_co_react(struct dg_co_node *self, enum dg_co_error_class class_of);

/** Hooks of 1001h, 1002h and 1003h. */
dg_co_hook dg_co_hook_error_register, dg_co_hook_status, dg_co_hook_history;

#endif
