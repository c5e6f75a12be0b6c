/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Time is a parameter. Every function of the core that depends on time takes `now`, and every
 * stack returns the next moment at which it wants to be stepped. The core never reads a clock,
 * so virtual time and real time are the same code.
 *
 * Unit: nanoseconds since an origin the host chooses (584 years fit). `now` never decreases from
 * one call to the next on the same object; a smaller value is treated as "no time has passed".
 */
#ifndef DREHGEBER_TIME_H
#define DREHGEBER_TIME_H

#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A moment or a span in nanoseconds. */
typedef uint64_t dg_ns;

/** The deadline of an object that waits for nothing. */
#define DG_NEVER UINT64_MAX

/** Spans; `n` is any non-negative integer expression. */
#define DG_US(n) ((dg_ns)(n)*1000u)
#define DG_MS(n) ((dg_ns)(n)*1000000u)
#define DG_S(n) ((dg_ns)(n)*1000000000u)

/** The moment `span` after `from`; DG_NEVER when it does not fit. */
static inline dg_ns dg_after(dg_ns from, dg_ns span)
{
    return span > DG_NEVER - from ? DG_NEVER : from + span;
}

/** Time from `since` to `now`; 0 when `since` is later. */
static inline dg_ns dg_elapsed(dg_ns now, dg_ns since)
{
    return now > since ? now - since : 0;
}

/** The earlier of two deadlines. */
static inline dg_ns dg_earliest(dg_ns a, dg_ns b)
{
    return a < b ? a : b;
}

/** `span` / `divisor` (1..65535), in steps of 32 bits: no machine needs a routine for it. */
DG_API dg_ns dg_divide_ns(dg_ns span, uint16_t divisor);

/**
 * Length of `bits` bit times at `baud` bits per second, rounded up to a whole nanosecond.
 * @param bits 0..65535
 * @param baud 1..10000000; 0 gives DG_NEVER
 */
DG_API dg_ns dg_bit_times_ns(uint32_t bits, uint32_t baud);

#ifdef __cplusplus
}
#endif

#endif
