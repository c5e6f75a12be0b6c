/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Exact arithmetic that motions and shafts share. C11 has no type of 128 bits.
 */
#ifndef DREHGEBER_MOTION_PRIVATE_H
#define DREHGEBER_MOTION_PRIVATE_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/angle.h"

/** 128 bits, modulo 2^128; where a sign is needed, two's complement. */
struct motion_wide {
    uint64_t high;
    uint64_t low;
};

/** |value|, also of INT64_MIN. */
uint64_t motion_exact_magnitude(int64_t value);

/** The angle `distance` before or after `from`. Modulo 2^64: an angle wraps, it never overflows. */
dg_angle motion_exact_moved(dg_angle from, bool backwards, uint64_t distance);

/** a * b / c towards minus infinity once the direction is applied: backwards, it rounds up. */
uint64_t motion_exact_muldiv(uint64_t a, uint64_t b, uint64_t c, bool backwards);

struct motion_wide motion_wide_product(uint64_t a, uint64_t b);
struct motion_wide motion_wide_add(struct motion_wide a, struct motion_wide b);
struct motion_wide motion_wide_subtract(struct motion_wide a, struct motion_wide b);
struct motion_wide motion_wide_negate(struct motion_wide a);
bool motion_wide_is_negative(struct motion_wide a);

/** a < b, both without sign. */
bool motion_wide_less(struct motion_wide a, struct motion_wide b);

/** a * b modulo 2^128, without sign. */
struct motion_wide motion_wide_times(struct motion_wide a, uint64_t b);

/** floor(a / b), without sign. @param b 1..2^63 */
struct motion_wide motion_wide_divide(struct motion_wide a, uint64_t b);

/** floor(sqrt(a)), without sign. */
uint64_t motion_wide_sqrt(struct motion_wide a);

#endif
