/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The SDO server. What its two halves share is in co_block.h.
 */
#ifndef DREHGEBER_CO_SDO_H
#define DREHGEBER_CO_SDO_H

#include "canopen_private.h"

/** Nothing is running; also when the NMT state ends what was. */
void dg_co_sdo_start(struct dg_co_node *self);
/** A request's 8 bytes. @return DG_CO_OK, or what dg_co_sdo_refuse() has to send: the last thing
 * that is done, so it is left to the caller */
enum dg_co_abort dg_co_sdo_rx(struct dg_co_node *self, const uint8_t *data);
/** End the transfer. */
void dg_co_sdo_abort(struct dg_co_node *self, enum dg_co_abort code);
/** The same, unless the device does it: dg_co_device.refused(). */
void dg_co_sdo_refuse(struct dg_co_node *self, const uint8_t *data, enum dg_co_abort abort);
dg_ns dg_co_sdo_step(struct dg_co_node *self);

#endif
