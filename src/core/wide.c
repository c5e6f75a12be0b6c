/* SPDX-License-Identifier: MIT */
/*
 * Division by multiplication: Moeller and Granlund, "Improved division by invariant integers", IEEE
 * Transactions on Computers 60 (2011). With d >= 2^63 and v = floor((2^128 - 1) / d) - 2^64, for
 * every u below d * 2^64
 *
 *   q1:q0 = v * u.high + u,  q = q1 + 1,  r = u.low - q * d        (modulo 2^64)
 *
 * q is floor(u / d), or too large by one, which r > q0 says, or, seldom, too small by one, which
 * r >= d says then. Other divisors are shifted to d, and the dividend with them; the quotient stays
 * what it is.
 */
#include "drehgeber/wide.h"

#include "drehgeber/angle.h"

#define HALF_BITS 32u
#define WORD_BITS 64u

#if defined(__SIZEOF_INT128__) && UINTPTR_MAX > UINT32_MAX
__extension__ typedef unsigned __int128 word_pair;

/** One instruction of a processor of 64 bits. */
static inline struct dg_wide multiply_wide(uint64_t a, uint64_t b)
{
    const word_pair product = (word_pair)a * b;

    return (struct dg_wide){.high = (uint64_t)(product >> WORD_BITS), .low = (uint64_t)product};
}
#else
/** Schoolbook multiplication in halves of 32 bits. */
static inline struct dg_wide multiply_wide(uint64_t a, uint64_t b)
{
    const uint32_t a_low = (uint32_t)a;
    const uint32_t a_high = (uint32_t)(a >> HALF_BITS);
    const uint32_t b_low = (uint32_t)b;
    const uint32_t b_high = (uint32_t)(b >> HALF_BITS);
    const uint64_t lows = dg_product(a_low, b_low);
    const uint64_t cross = dg_product(a_high, b_low) + (lows >> HALF_BITS);
    const uint64_t other_cross = dg_product(a_low, b_high) + (uint32_t)cross;

    return (struct dg_wide){
        .high = dg_product(a_high, b_high) + (cross >> HALF_BITS) + (other_cross >> HALF_BITS),
        .low = other_cross << HALF_BITS | (uint32_t)lows,
    };
}
#endif

uint64_t dg_divide_by(struct dg_wide value, const struct dg_reciprocal *by, uint64_t *rest)
{
    struct dg_wide q = multiply_wide(by->inverse, value.high);

    q.low += value.low;
    q.high += value.high + (q.low < value.low ? 1u : 0u) + 1u;
    uint64_t left = value.low - q.high * by->divisor;
    if (left > q.low) {
        q.high--;
        left += by->divisor;
    }
    if (left >= by->divisor) {
        q.high++;
        left -= by->divisor;
    }
    *rest = left;
    return q.high;
}

struct dg_wide dg_wide_product(uint64_t a, uint64_t b)
{
    return multiply_wide(a, b);
}

static uint8_t zeros_in_front(uint64_t value)
{
    uint8_t zeros = 0;

    for (uint8_t step = HALF_BITS; step > 0; step /= 2u) {
        if (value >> (WORD_BITS - step) == 0) {
            value <<= step;
            zeros = (uint8_t)(zeros + step);
        }
    }
    return zeros;
}

/** floor((2^19 - 3 * 2^8) / d9), d9 in 2^8..2^9-1, without a call of the compiler's library. */
static uint32_t first_bits(uint32_t d9)
{
    uint32_t left = 0x7FD00;
    uint32_t quotient = 0;

    for (int bit = 10; bit >= 0; bit--) {
        if (left >= d9 << bit) {
            left -= d9 << bit;
            quotient |= 1u << bit;
        }
    }
    return quotient;
}

/** Their RECIPROCAL_WORD: 11 bits by division, 21, 34 and 64 by Newton's iteration. Modulo
 * 2^64, as there. @param d at least 2^63 */
static uint64_t inverse_of(uint64_t d)
{
    const uint64_t d40 = (d >> 24) + 1u;
    const uint64_t d63 = (d >> 1) + (d & 1u);
    const uint64_t v0 = first_bits((uint32_t)(d >> 55));
    const uint64_t v1 = (v0 << 11) - (v0 * v0 * d40 >> 40) - 1u;
    const uint64_t v2 = (v1 << 13) + (v1 * (((uint64_t)1 << 60) - v1 * d40) >> 47);
    const uint64_t e = (0u - v2 * d63) + ((d & 1u) != 0 ? v2 >> 1 : 0u);
    const uint64_t v3 = (v2 << 31) + (multiply_wide(v2, e).high >> 1);
    struct dg_wide last = multiply_wide(v3, d);

    last.low += d;
    last.high += d + (last.low < d ? 1u : 0u);
    return v3 - last.high;
}

struct dg_reciprocal dg_reciprocal_of(uint64_t divisor)
{
    const uint8_t shift = zeros_in_front(divisor);

    return (struct dg_reciprocal){
        .divisor = divisor << shift,
        .inverse = inverse_of(divisor << shift),
        .shift = shift,
    };
}

uint64_t dg_muldiv(uint64_t a, uint64_t b, uint64_t c)
{
    struct dg_wide product = multiply_wide(a, b);
    uint64_t rest;

    if (product.high >= c) {
        return UINT64_MAX; /* covers c = 0 */
    }
    const struct dg_reciprocal by = dg_reciprocal_of(c);
    /* In two steps: a shift by 64 is undefined. */
    product.high = product.high << by.shift | product.low >> 1 >> (WORD_BITS - 1u - by.shift);
    product.low <<= by.shift;
    return dg_divide_by(product, &by, &rest);
}
