/* SPDX-License-Identifier: MIT */
#include "drehgeber/angle.h"
#include "drehgeber/wide.h"

/** A quarter of a period in phase units. */
#define QUARTER ((uint32_t)1 << 30)

/*
 * sin(pi/2 u) = u (C0 - z (C1 - z (C2 - z (C3 - z (C4 - z C5))))) with z = u^2: the odd polynomial
 * through the Chebyshev nodes of degree 13, stretched so that the largest is u = 1; it is off by
 * less than 2^-35. Signs alternate and every bracket stays positive, so unsigned numbers do.
 * In units of 2^-32; C0 - C1 + C2 - C3 + C4 - C5 = 1, which makes the peak exact. With what is
 * rounded on the way, the result is off by less than 1.2 units of 2^-30 at every phase.
 */
#define C0 UINT64_C(6746518852)
#define C1 2774394651u
#define C2 342277046u
#define C3 20107380u
#define C4 688099u
#define C5 14670u

/** a * b * 2^-32, to the nearest. */
static uint32_t scale_fraction(uint32_t a, uint32_t b)
{
    const uint64_t product = dg_product(a, b);

    return (uint32_t)(product >> 32) + ((uint32_t)product >> 31);
}

/** Sine of the first quarter period, both ends included. */
static int32_t first_quarter(uint32_t u)
{
    uint32_t sum = C5;

    if (u == QUARTER) {
        return (int32_t)QUARTER; /* z below would be 2^32 */
    }
    const uint32_t z = (uint32_t)(dg_product(u, u) >> 28); /* 2^-60 to 2^-32 */
    sum = C4 - scale_fraction(sum, z);
    sum = C3 - scale_fraction(sum, z);
    sum = C2 - scale_fraction(sum, z);
    sum = C1 - scale_fraction(sum, z);
    const uint64_t whole = C0 - (uint64_t)scale_fraction(sum, z);
    return (int32_t)(scale_fraction((uint32_t)whole, u) + ((whole >> 32) != 0 ? u : 0u));
}

int32_t dg_sin_q30(uint32_t phase)
{
    uint32_t quadrant = phase >> 30;
    uint32_t u = phase & (QUARTER - 1);
    int32_t sine = first_quarter((quadrant & 1) != 0 ? QUARTER - u : u);

    return (quadrant & 2) != 0 ? -sine : sine;
}
