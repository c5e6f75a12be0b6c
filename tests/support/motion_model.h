/* SPDX-License-Identifier: MIT */
/** What tests of shafts compute with: wide integers, and random motions that repeat. */
#ifndef TESTS_SUPPORT_MOTION_MODEL_H
#define TESTS_SUPPORT_MOTION_MODEL_H

#include <stdint.h>

#include "drehgeber/angle.h"

__extension__ typedef __int128 wide;

/** splitmix64 */
uint64_t random_bits(uint64_t *seed);

/** 1..limit, small ones as frequent as large ones. */
uint64_t random_up_to(uint64_t *seed, uint64_t limit);

/** A speed of either direction, not 0, up to DG_MOTION_SPEED_MAX_MRPM. */
int32_t random_mrpm(uint64_t *seed);

/** c > 0 */
wide floor_div(wide a, wide c);

/** Modulo 2^64, as the angle wraps. */
dg_angle wrapped(wide angle);

#endif
