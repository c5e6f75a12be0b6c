/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Layer setting services: node-ID and bit rate over the bus.
 */
#ifndef DREHGEBER_CO_LSS_H
#define DREHGEBER_CO_LSS_H

#include "canopen_private.h"

void dg_co_lss_start(struct dg_co_node *self);
void dg_co_lss_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
dg_ns dg_co_lss_step(struct dg_co_node *self);
/** Whether the bus is silent because of a bit rate switch. */
static inline bool co_lss_silent(const struct dg_co_node *self)
{
    return self->now < self->lss.silent_until;
}

#endif
