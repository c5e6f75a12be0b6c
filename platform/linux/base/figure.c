/* SPDX-License-Identifier: MIT */
/*
 * No strtod(): it rounds and follows the locale. No strtoll(): it skips blanks, takes signs where
 * none belong and stops at the first character it does not like.
 */
#include "figure.h"

#include <string.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Append a digit; false when the value would leave 64 bits. */
static bool push(int64_t *value, int digit)
{
    if (*value > (INT64_MAX - digit) / 10) {
        return false;
    }
    *value = *value * 10 + digit;
    return true;
}

bool lx_decimal_parse(const char *text, size_t n, unsigned places, struct lx_decimal *out)
{
    size_t i = 0;
    const bool negative = n > 0 && text[0] == '-';
    if (n > 0 && (text[0] == '-' || text[0] == '+')) {
        i = 1;
    }
    int64_t value = 0;
    unsigned fraction = 0;
    bool point = false;
    bool any = false;
    bool cut = false;
    for (; i < n; i++) {
        if (text[i] == '.' && !point) {
            point = true;
            continue;
        }
        if (!is_digit(text[i])) {
            return false;
        }
        any = true;
        /* Beyond the last place: noted, not rounded. */
        if (point && fraction == places) {
            cut = cut || text[i] != '0';
            continue;
        }
        fraction += point ? 1u : 0u;
        if (!push(&value, text[i] - '0')) {
            return false;
        }
    }
    /* "1.5" with 3 places is 1500. */
    for (; fraction < places; fraction++) {
        if (!push(&value, 0)) {
            return false;
        }
    }
    out->value = negative ? -value : value;
    out->cut = cut;
    return any;
}

static int digit_of(char c)
{
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *at = c == '\0' ? NULL : strchr(digits, c);
    return at == NULL ? -1 : (int)((at - digits) % 16);
}

bool lx_unsigned_parse(const char *text, uint64_t *out)
{
    size_t n = strlen(text);
    uint64_t base = 10;
    if (n > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X')) {
        base = 16;
        text += 2;
        n -= 2;
    } else if (n > 1 && (text[n - 1] == 'h' || text[n - 1] == 'H')) {
        base = 16;
        n -= 1;
    }
    uint64_t value = 0;
    for (size_t i = 0; i < n; i++) {
        const int digit = digit_of(text[i]);
        if (digit < 0 || (uint64_t)digit >= base || value > (UINT64_MAX - (uint64_t)digit) / base) {
            return false;
        }
        value = value * base + (uint64_t)digit;
    }
    *out = value;
    return n > 0;
}

int64_t lx_power_of_ten(unsigned places)
{
    int64_t value = 1;
    for (unsigned i = 0; i < places; i++) {
        value *= 10;
    }
    return value;
}

/* num * 2^32 / den rounded up, for num >= 0. The 64-bit remainder of the wrapped product is exact
   because it is below `den`. */
static int64_t scale_up(uint64_t num, uint64_t den)
{
    const uint64_t quotient = dg_muldiv(num, (uint64_t)DG_TURN, den);
    const uint64_t rest = (num << 32) - quotient * den;
    return (int64_t)(quotient + (rest != 0 ? 1u : 0u));
}

dg_angle lx_angle_of_degrees(int64_t value, unsigned places)
{
    const uint64_t den = 360u * (uint64_t)lx_power_of_ten(places);
    if (value >= 0) {
        return scale_up((uint64_t)value, den);
    }
    return -(int64_t)dg_muldiv((uint64_t)-value, (uint64_t)DG_TURN, den);
}
