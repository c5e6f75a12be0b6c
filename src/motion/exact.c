/* SPDX-License-Identifier: MIT */
#include "motion_private.h"

#define LIMB_BITS 16
#define WORD_BITS 64

uint64_t dg_motion_exact_magnitude(int64_t value)
{
    return value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
}

dg_angle dg_motion_exact_moved(dg_angle from, bool backwards, uint64_t distance)
{
    return (dg_angle)(backwards ? (uint64_t)from - distance : (uint64_t)from + distance);
}

uint64_t dg_motion_exact_muldiv(uint64_t a, uint64_t b, uint64_t c, bool backwards)
{
    uint64_t quotient = dg_muldiv(a, b, c);
    bool inexact = a * b - quotient * c != 0; /* the remainder is below c: its low half says all */

    return backwards && inexact ? quotient + 1 : quotient;
}

uint16_t dg_motion_limbs_add(uint16_t *sum, uint16_t a, const uint16_t *b, unsigned limbs)
{
    uint32_t carry = 0;

    for (unsigned i = 0; i < limbs; i++) {
        carry += (uint32_t)a * b[i] + sum[i]; /* at most 2^32 - 1 */
        sum[i] = (uint16_t)carry;
        carry >>= LIMB_BITS;
    }
    return (uint16_t)carry;
}

struct dg_wide dg_motion_wide_add(struct dg_wide a, struct dg_wide b)
{
    uint64_t low = a.low + b.low;

    return (struct dg_wide){.high = a.high + b.high + (low < a.low ? 1u : 0u), .low = low};
}

struct dg_wide dg_motion_wide_subtract(struct dg_wide a, struct dg_wide b)
{
    return (struct dg_wide){.high = a.high - b.high - (a.low < b.low ? 1u : 0u),
                            .low = a.low - b.low};
}

struct dg_wide dg_motion_wide_negate(struct dg_wide a)
{
    return dg_motion_wide_subtract((struct dg_wide){0, 0}, a);
}

bool dg_motion_wide_is_negative(struct dg_wide a)
{
    return a.high >> (WORD_BITS - 1) != 0;
}

bool dg_motion_wide_less(struct dg_wide a, struct dg_wide b)
{
    return a.high < b.high || (a.high == b.high && a.low < b.low);
}

struct dg_wide dg_motion_wide_times(struct dg_wide a, uint64_t b)
{
    struct dg_wide product = dg_wide_product(a.low, b);

    product.high += a.high * b;
    return product;
}

struct dg_wide dg_motion_wide_divide(struct dg_wide a, uint64_t b)
{
    uint64_t rest = a.high % b;
    uint64_t shift = a.low; /* bits of the dividend leave at the top, the quotient's enter */

    for (int i = 0; i < WORD_BITS; i++) {
        rest = (rest << 1) | (shift >> (WORD_BITS - 1)); /* rest < b <= 2^63: nothing is lost */
        shift <<= 1;
        if (rest >= b) {
            rest -= b;
            shift |= 1;
        }
    }
    return (struct dg_wide){.high = a.high / b, .low = shift};
}

/** The root bit by bit, from the top. */
uint64_t dg_motion_wide_sqrt(struct dg_wide a)
{
    uint64_t root = 0;

    for (uint64_t bit = (uint64_t)1 << (WORD_BITS - 1); bit != 0; bit >>= 1) {
        uint64_t larger = root | bit;

        if (!dg_motion_wide_less(a, dg_wide_product(larger, larger))) {
            root = larger;
        }
    }
    return root;
}
