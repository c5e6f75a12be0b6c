/* SPDX-License-Identifier: MIT */
#include "drehgeber/angle.h"

/** A quarter of a period in phase units. */
#define QUARTER ((uint32_t)1 << 30)

/** Half of the last bit that `>> 32` drops. */
#define HALF ((uint64_t)1 << 31)

/*
 * sin(pi/2 u) = u (C0 - z (C1 - z (C2 - z (C3 - z (C4 - z C5))))) with z = u^2: the odd polynomial
 * through the Chebyshev nodes of degree 13, stretched so that the largest is u = 1; it is off by
 * less than 2^-35. Signs alternate and every bracket stays positive, so unsigned numbers do.
 * In units of 2^-32; C0 - C1 + C2 - C3 + C4 - C5 = 1, which makes the peak exact. With what is
 * rounded on the way, the result is off by less than 1.2 units of 2^-30 at every phase.
 */
#define C0 6746518852u
#define C1 2774394651u
#define C2 342277046u
#define C3 20107380u
#define C4 688099u
#define C5 14670u

/** Sine of the first quarter period, both ends included. */
static int32_t first_quarter(uint32_t u)
{
    uint64_t z = (uint64_t)u * u >> 28; /* 2^-60 to 2^-32; the peak is 2^32 */
    uint64_t sum = C5;

    sum = C4 - ((sum * z + HALF) >> 32);
    sum = C3 - ((sum * z + HALF) >> 32);
    sum = C2 - ((sum * z + HALF) >> 32);
    sum = C1 - ((sum * z + HALF) >> 32);
    sum = C0 - ((sum * z + HALF) >> 32);
    return (int32_t)((sum * u + HALF) >> 32);
}

int32_t dg_sin_q30(uint32_t phase)
{
    uint32_t quadrant = phase >> 30;
    uint32_t u = phase & (QUARTER - 1);
    int32_t sine = first_quarter((quadrant & 1) != 0 ? QUARTER - u : u);

    return (quadrant & 2) != 0 ? -sine : sine;
}
