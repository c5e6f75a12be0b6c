/* SPDX-License-Identifier: MIT */
#include "motion_model.h"

#include "drehgeber/motion.h"

uint64_t random_bits(uint64_t *seed)
{
    uint64_t z = *seed += 0x9E3779B97F4A7C15u;

    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

uint64_t random_up_to(uint64_t *seed, uint64_t limit)
{
    uint64_t bits = random_bits(seed);

    return (bits >> (random_bits(seed) % 64)) % limit + 1;
}

int32_t random_mrpm(uint64_t *seed)
{
    int32_t mrpm = (int32_t)random_up_to(seed, DG_MOTION_SPEED_MAX_MRPM);

    return (random_bits(seed) & 1) != 0 ? mrpm : -mrpm;
}

wide floor_div(wide a, wide c)
{
    return a / c - (a % c < 0 ? 1 : 0);
}

dg_angle wrapped(wide angle)
{
    return (dg_angle)(uint64_t)angle;
}
