/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Numbers from text, exactly and independent of the locale.
 */
#ifndef DREHGEBER_FIGURE_H
#define DREHGEBER_FIGURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/angle.h"
#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A decimal as it was written. */
struct dg_decimal {
    int64_t value; /**< in units of 10^-places */
    bool cut;      /**< there were digits other than 0 beyond `places`; they are not in `value` */
};

/**
 * Parse `n` characters as [+-]digits[.digits] into units of 10^-places.
 * @return false when they are anything else (also an exponent), or leave 64 bits
 */
DG_API bool dg_decimal_parse(const char *text, size_t n, unsigned places, struct dg_decimal *out);

/** Parse a whole string, up to 4095 characters, as an unsigned number: 39, 0x27 or 27h. */
DG_API bool dg_unsigned_parse(const char *text, uint64_t *out);

/** 10^places, places 0..18. */
DG_API int64_t dg_power_of_ten(unsigned places);

/** `value` / 10^places degrees as an angle, rounded up; |degrees| at most 6 * 10^9. */
DG_API dg_angle dg_angle_of_degrees(int64_t value, unsigned places);

#ifdef __cplusplus
}
#endif

#endif
