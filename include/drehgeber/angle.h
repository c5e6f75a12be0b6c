/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Angles: signed 64-bit integers in units of 2^-32 turn. Positive is clockwise, looking at the
 * shaft. Range +-2^31 turns (124 days at 12 000 rpm in one direction) before the type wraps.
 * Everything is exact integer arithmetic; where something is rounded, the function says how.
 */
#ifndef DREHGEBER_ANGLE_H
#define DREHGEBER_ANGLE_H

#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An angle in units of 2^-32 turn. */
typedef int64_t dg_angle;

/** One full turn. */
#define DG_TURN ((dg_angle)1 << 32)

/**
 * Counts of an encoder with `counts_per_turn` at `angle`: floor(angle * counts_per_turn / 2^32),
 * exact for every angle. Rounds towards minus infinity, so that counts are equally wide on both
 * sides of zero.
 * @param counts_per_turn 1..2^32-1
 */
DG_API int64_t dg_angle_counts(dg_angle angle, uint32_t counts_per_turn);

/**
 * The smallest angle whose dg_angle_counts() is `counts`: ceil(counts * 2^32 / counts_per_turn).
 * @param counts such that the angle fits its type (otherwise it wraps modulo 2^64)
 * @param counts_per_turn 1..2^32-1
 */
DG_API dg_angle dg_angle_of_counts(int64_t counts, uint32_t counts_per_turn);

/** `value` modulo `range`, always in 0..range-1. @param range 1..2^62 */
DG_API uint64_t dg_mod(int64_t value, uint64_t range);

/**
 * floor(a * b / c) with the full 128-bit product in between.
 * @param c UINT64_MAX is returned when the quotient does not fit 64 bits, or c is 0
 */
DG_API uint64_t dg_muldiv(uint64_t a, uint64_t b, uint64_t c);

/**
 * Sine of `phase` (2^32 = one period), scaled to +-2^30. Error below 1.2 units; exact at the
 * quarter points, sin(-x) = -sin(x), and dg_sin_q30(p + 2^30) is the cosine.
 */
DG_API int32_t dg_sin_q30(uint32_t phase);

/** floor(sqrt(value)). */
DG_API uint32_t dg_isqrt(uint64_t value);

#ifdef __cplusplus
}
#endif

#endif
