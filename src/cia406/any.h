/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder of the profile with any number of steps and turns, for EDS files (any.c, any_file.c).
 */
#ifndef DREHGEBER_CIA406_ANY_H
#define DREHGEBER_CIA406_ANY_H

#include "cia406_private.h"

/** Bits of 6300h that were set at the last look, a byte for each channel (ranges.c). */
#define SLOT_CAMS (SLOT_CUSTOMER + 2)
/** Channels of cams and work areas. */
#define CHANNELS 4u
dg_co_hook dg_cia406_hook_cams, dg_cia406_hook_channel;

/** Positions that 6004h can have: 1..2^32. */
uint64_t dg_cia406_any_range(const struct dg_co_node *node);

#endif
