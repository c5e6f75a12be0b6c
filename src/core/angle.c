/* SPDX-License-Identifier: MIT */
#include "drehgeber/angle.h"

#include "drehgeber/wide.h"

int64_t dg_angle_counts(dg_angle angle, uint32_t counts_per_turn)
{
    /* angle = turns * 2^32 + part with 0 <= part: only the part is rounded, and downwards. */
    const uint32_t part = (uint32_t)angle;
    const int64_t turns = (int32_t)(uint32_t)((uint64_t)angle >> 32);

    return turns * (int64_t)counts_per_turn + (int64_t)(dg_product(part, counts_per_turn) >> 32);
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

    if ((range & (range - 1u)) == 0) {
        return (uint64_t)value & (range - 1u); /* also below 0: 2^64 is a multiple of it */
    }
    if (value >= 0) {
        return (uint64_t)value % range;
    }
    rest = (0 - (uint64_t)value) % range;
    return rest != 0 ? range - rest : 0;
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
