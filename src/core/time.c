/* SPDX-License-Identifier: MIT */
#include "drehgeber/time.h"

dg_ns dg_bit_times_ns(uint32_t bits, uint32_t baud)
{
    if (baud == 0) {
        return DG_NEVER;
    }
    return (DG_S(bits) + baud - 1) / baud;
}
