/* SPDX-License-Identifier: MIT */
#include "drehgeber/angle.h"

#include <stdbool.h>

/** A product of 128 bits. */
struct wide {
    uint64_t high;
    uint64_t low;
};

int64_t dg_angle_counts(dg_angle angle, uint32_t counts_per_turn)
{
    /* angle = turns * 2^32 + part with 0 <= part: only the part is rounded, and downwards. */
    uint32_t part = (uint32_t)angle;
    int64_t turns = (angle - (int64_t)part) / DG_TURN;

    return turns * (int64_t)counts_per_turn + (int64_t)((uint64_t)part * counts_per_turn >> 32);
}

dg_angle dg_angle_of_counts(int64_t counts, uint32_t counts_per_turn)
{
    int64_t turns = counts / (int64_t)counts_per_turn;
    int64_t rest = counts % (int64_t)counts_per_turn;
    uint64_t part;

    if (rest < 0) { /* C truncates; the part of a turn counts up from the turn below */
        rest += (int64_t)counts_per_turn;
        turns -= 1;
    }
    part = (((uint64_t)rest << 32) + counts_per_turn - 1) / counts_per_turn;
    /* Modulo 2^64: the lowest whole turn of the type is no special case, and nothing is undefined
     * for counts outside the documented range. */
    return (dg_angle)(((uint64_t)turns << 32) + part);
}

uint64_t dg_mod(int64_t value, uint64_t range)
{
    uint64_t rest;

    if (value >= 0) {
        return (uint64_t)value % range;
    }
    rest = (0 - (uint64_t)value) % range;
    return rest != 0 ? range - rest : 0;
}

/** Schoolbook multiplication in halves of 32 bits: C11 has no type for the product. */
static struct wide multiply(uint64_t a, uint64_t b)
{
    uint64_t a_low = a & UINT32_MAX;
    uint64_t b_low = b & UINT32_MAX;
    uint64_t lows = a_low * b_low;
    uint64_t cross = (a >> 32) * b_low + (lows >> 32);
    uint64_t other_cross = a_low * (b >> 32) + (cross & UINT32_MAX);

    return (struct wide){
        .high = (a >> 32) * (b >> 32) + (cross >> 32) + (other_cross >> 32),
        .low = (other_cross << 32) | (lows & UINT32_MAX),
    };
}

/** dividend / divisor, one bit of the quotient a round; needs dividend.high < divisor. */
static uint64_t divide(struct wide dividend, uint64_t divisor)
{
    uint64_t rest = dividend.high;
    uint64_t shift = dividend.low; /* bits of the dividend leave at the top, the quotient's enter */

    for (int i = 0; i < 64; i++) {
        bool carry = (rest >> 63) != 0;

        rest = (rest << 1) | (shift >> 63);
        shift <<= 1;
        if (carry || rest >= divisor) {
            rest -= divisor;
            shift |= 1;
        }
    }
    return shift;
}

uint64_t dg_muldiv(uint64_t a, uint64_t b, uint64_t c)
{
    struct wide product = multiply(a, b);

    if (product.high >= c) {
        return UINT64_MAX; /* covers c = 0 */
    }
    return product.high == 0 ? product.low / c : divide(product, c);
}

uint32_t dg_isqrt(uint64_t value)
{
    uint64_t root = 0;

    /* Digit by digit in base 4: `root` is the root so far, shifted to the place of `bit`. */
    for (uint64_t bit = (uint64_t)1 << 62; bit != 0; bit >>= 2) {
        if (value >= root + bit) {
            value -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    return (uint32_t)root;
}
