/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The SDO server. What its two halves share is in co_block.h.
 */
#ifndef DREHGEBER_CO_SDO_H
#define DREHGEBER_CO_SDO_H

#include "canopen_private.h"

/** Nothing is running; also when the NMT state ends what was. */
void co_sdo_start(struct dg_co_node *self);
void co_sdo_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
dg_ns co_sdo_step(struct dg_co_node *self);

#endif
