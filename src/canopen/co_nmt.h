/* SPDX-License-Identifier: MIT */
/**
 * @file
 * NMT state machine, node and life guarding, heartbeat producer and consumers.
 */
#ifndef DREHGEBER_CO_NMT_H
#define DREHGEBER_CO_NMT_H

#include "canopen_private.h"

void dg_co_nmt_start(struct dg_co_node *self);
void dg_co_nmt_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
/** Change the state, and tell the services that live by it. */
void dg_co_enter(struct dg_co_node *self, enum dg_co_state state);
/** The master's request to guarding: a remote frame. */
void dg_co_guard_rx(struct dg_co_node *self);
void dg_co_heartbeat_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
dg_ns dg_co_nmt_step(struct dg_co_node *self);

/** Hooks of 1016h; of 1017h, 100Ch and 100Dh. */
dg_co_hook dg_co_hook_consumer, dg_co_hook_heartbeat;

#endif
