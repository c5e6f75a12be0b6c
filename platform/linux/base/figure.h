/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Numbers from text, exactly and independent of the locale.
 */
#ifndef DREHGEBER_LINUX_FIGURE_H
#define DREHGEBER_LINUX_FIGURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/angle.h"

/** A decimal as it was written. */
struct lx_decimal {
    int64_t value; /**< in units of 10^-places */
    bool cut;      /**< there were digits other than 0 beyond `places`; they are not in `value` */
};

/**
 * Parse `n` characters as [+-]digits[.digits] into units of 10^-places.
 * @return false when they are anything else (also an exponent), or leave 64 bits
 */
bool lx_decimal_parse(const char *text, size_t n, unsigned places, struct lx_decimal *out);

/** Parse a whole string as an unsigned number: 39, 0x27 or 27h. */
bool lx_unsigned_parse(const char *text, uint64_t *out);

/** 10^places, places 0..18. */
int64_t lx_power_of_ten(unsigned places);

/** `value` / 10^places degrees as an angle, rounded up; |degrees| at most 6 * 10^9. */
dg_angle lx_angle_of_degrees(int64_t value, unsigned places);

#endif
