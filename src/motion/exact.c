/* SPDX-License-Identifier: MIT */
#include "motion_private.h"

#define HALF_BITS 32
#define WORD_BITS 64

uint64_t motion_exact_magnitude(int64_t value)
{
    return value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
}

dg_angle motion_exact_moved(dg_angle from, bool backwards, uint64_t distance)
{
    return (dg_angle)(backwards ? (uint64_t)from - distance : (uint64_t)from + distance);
}

uint64_t motion_exact_muldiv(uint64_t a, uint64_t b, uint64_t c, bool backwards)
{
    uint64_t quotient = dg_muldiv(a, b, c);
    bool inexact = a * b - quotient * c != 0; /* the remainder is below c: its low half says all */

    return backwards && inexact ? quotient + 1 : quotient;
}

/** Schoolbook multiplication in halves. */
struct motion_wide motion_wide_product(uint64_t a, uint64_t b)
{
    uint64_t a_low = a & UINT32_MAX;
    uint64_t b_low = b & UINT32_MAX;
    uint64_t cross = (a >> HALF_BITS) * b_low + (a_low * b_low >> HALF_BITS);
    uint64_t other_cross = a_low * (b >> HALF_BITS) + (cross & UINT32_MAX);

    return (struct motion_wide){
        .high =
            (a >> HALF_BITS) * (b >> HALF_BITS) + (cross >> HALF_BITS) + (other_cross >> HALF_BITS),
        .low = a * b,
    };
}

struct motion_wide motion_wide_add(struct motion_wide a, struct motion_wide b)
{
    uint64_t low = a.low + b.low;

    return (struct motion_wide){.high = a.high + b.high + (low < a.low ? 1u : 0u), .low = low};
}

struct motion_wide motion_wide_subtract(struct motion_wide a, struct motion_wide b)
{
    return (struct motion_wide){.high = a.high - b.high - (a.low < b.low ? 1u : 0u),
                                .low = a.low - b.low};
}

struct motion_wide motion_wide_negate(struct motion_wide a)
{
    return motion_wide_subtract((struct motion_wide){0, 0}, a);
}

bool motion_wide_is_negative(struct motion_wide a)
{
    return a.high >> (WORD_BITS - 1) != 0;
}

bool motion_wide_less(struct motion_wide a, struct motion_wide b)
{
    return a.high < b.high || (a.high == b.high && a.low < b.low);
}

struct motion_wide motion_wide_times(struct motion_wide a, uint64_t b)
{
    struct motion_wide product = motion_wide_product(a.low, b);

    product.high += a.high * b;
    return product;
}

struct motion_wide motion_wide_divide(struct motion_wide a, uint64_t b)
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
    return (struct motion_wide){.high = a.high / b, .low = shift};
}

/** The root bit by bit, from the top. */
uint64_t motion_wide_sqrt(struct motion_wide a)
{
    uint64_t root = 0;

    for (uint64_t bit = (uint64_t)1 << (WORD_BITS - 1); bit != 0; bit >>= 1) {
        uint64_t larger = root | bit;

        if (!motion_wide_less(a, motion_wide_product(larger, larger))) {
            root = larger;
        }
    }
    return root;
}
