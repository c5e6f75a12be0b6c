/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Exact arithmetic that motions and shafts share. C11 has no type of 128 bits.
 */
#ifndef DREHGEBER_MOTION_PRIVATE_H
#define DREHGEBER_MOTION_PRIVATE_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/motion.h"
#include "drehgeber/wide.h"

/** |value|, also of INT64_MIN. */
uint64_t dg_motion_exact_magnitude(int64_t value);

/** The angle `distance` before or after `from`. Modulo 2^64: an angle wraps, it never overflows. */
dg_angle dg_motion_exact_moved(dg_angle from, bool backwards, uint64_t distance);

/** a * b / c towards minus infinity once the direction is applied: backwards, it rounds up. */
uint64_t dg_motion_exact_muldiv(uint64_t a, uint64_t b, uint64_t c, bool backwards);

/** A row of a long multiplication in limbs of 16 bits, the lowest one first, whose products and
 * carries fit the 32 bits that the smallest processors multiply to: sum += a * b.
 * @return the carry into the next limb */
uint16_t dg_motion_limbs_add(uint16_t *sum, uint16_t a, const uint16_t *b, unsigned limbs);

/** dg_motion_angle() */
dg_angle dg_motion_angle_at(const struct dg_motion *self, dg_ns now);

struct dg_wide dg_motion_wide_add(struct dg_wide a, struct dg_wide b);
struct dg_wide dg_motion_wide_subtract(struct dg_wide a, struct dg_wide b);
struct dg_wide dg_motion_wide_negate(struct dg_wide a);
bool dg_motion_wide_is_negative(struct dg_wide a);

/** a < b, both without sign. */
bool dg_motion_wide_less(struct dg_wide a, struct dg_wide b);

/** a * b modulo 2^128, without sign. */
struct dg_wide dg_motion_wide_times(struct dg_wide a, uint64_t b);

/** floor(a / b), without sign. @param b 1..2^63 */
struct dg_wide dg_motion_wide_divide(struct dg_wide a, uint64_t b);

/** floor(sqrt(a)), without sign. */
uint64_t dg_motion_wide_sqrt(struct dg_wide a);

#endif
