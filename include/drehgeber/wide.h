/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Products of 128 bits, and exact division of them by what stays the same. C11 has no type for
 * the one, and small processors no instruction for the other: a Cortex-M0+ takes 400 to 1200
 * cycles for a division of 64 bits. What is divided by often is turned into a reciprocal once;
 * then a division is two multiplications, and never off by one.
 */
#ifndef DREHGEBER_WIDE_H
#define DREHGEBER_WIDE_H

#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__ARM_ARCH_ISA_THUMB) && __ARM_ARCH_ISA_THUMB == 1
/** a * b. Armv6-M multiplies 32 bits to 32: by halves of 16 in place it is half of what the call
 * takes that a compiler makes of the product. */
static inline uint64_t dg_product(uint32_t a, uint32_t b)
{
    const uint32_t a_low = a & 0xFFFFu;
    const uint32_t b_low = b & 0xFFFFu;
    const uint32_t lows = a_low * b_low;
    const uint32_t cross = (a >> 16) * b_low + (lows >> 16);
    const uint32_t other_cross = a_low * (b >> 16) + (cross & 0xFFFFu);
    const uint32_t high = (a >> 16) * (b >> 16) + (cross >> 16) + (other_cross >> 16);

    return (uint64_t)high << 32 | (other_cross << 16 | (lows & 0xFFFFu));
}
#else
/** a * b. */
static inline uint64_t dg_product(uint32_t a, uint32_t b)
{
    return (uint64_t)a * b;
}
#endif

/** 128 bits, modulo 2^128. */
struct dg_wide {
    uint64_t high;
    uint64_t low;
};

/** a * b, exact. */
DG_API struct dg_wide dg_wide_product(uint64_t a, uint64_t b);

/** What a division by a number is replaced by. */
struct dg_reciprocal {
    uint64_t divisor; /**< shifted up until its highest bit is set */
    uint64_t inverse; /**< floor((2^128 - 1) / divisor) - 2^64 */
    uint8_t shift;    /**< by so much */
};

/** The reciprocal of `divisor`, without a division of 64 bits. @param divisor 1..2^64-1 */
DG_API struct dg_reciprocal dg_reciprocal_of(uint64_t divisor);

/**
 * floor(value / by->divisor): of a value that was shifted up, too, the quotient of the two as they
 * were.
 * @param value its high half is below by->divisor
 * @param rest what is left, likewise shifted
 */
DG_API uint64_t dg_divide_by(struct dg_wide value, const struct dg_reciprocal *by, uint64_t *rest);

#ifdef __cplusplus
}
#endif

#endif
