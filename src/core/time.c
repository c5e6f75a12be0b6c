/* SPDX-License-Identifier: MIT */
#include "drehgeber/time.h"

dg_ns dg_bit_times_ns(uint32_t bits, uint32_t baud)
{
    if (baud == 0) {
        return DG_NEVER;
    }
    return (DG_S(bits) + baud - 1) / baud;
}

dg_ns dg_divide_ns(dg_ns span, uint16_t divisor)
{
    dg_ns quotient = 0;
    uint32_t rest = 0;

    for (int shift = 48; shift >= 0; shift -= 16) {
        rest = rest << 16 | (uint16_t)(span >> shift);
        quotient = quotient << 16 | rest / divisor;
        rest %= divisor;
    }
    return quotient;
}
