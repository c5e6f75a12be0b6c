/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Parameters that survive power-off: 1010h, 1011h, the bus parameters.
 */
#ifndef DREHGEBER_CO_STORAGE_H
#define DREHGEBER_CO_STORAGE_H

#include "canopen_private.h"

/** Mount the store and read what is not a value: bus parameters, serial number. */
int dg_co_mount_node(struct dg_co_node *self);
/** Check the memory again, as every Initialisation does; bus parameters in force stay. */
void dg_co_remount(struct dg_co_node *self);
/** Values of the rows from `first` to `last` index: defaults, then what 1010h has saved. False when
 * some of that cannot be read; those are the defaults. */
bool dg_co_load(struct dg_co_node *self, uint16_t first, uint16_t last);
/** Keep number of the bit rate and node-ID for the next start. */
enum dg_co_abort dg_co_save_bus(struct dg_co_node *self, uint8_t bit_rate, uint8_t node_id);
/** 5100h when stored parameters are damaged, or not `loaded` (see dg_co_load()). */
void dg_co_report_memory(struct dg_co_node *self, bool loaded);

/** Hooks of 1010h and 1011h. */
dg_co_hook dg_co_hook_store, dg_co_hook_restore;

#endif
