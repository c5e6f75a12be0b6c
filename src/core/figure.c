/* SPDX-License-Identifier: MIT */
/*
 * No strtod(): it rounds and follows the locale. No strtoll(): it skips blanks, takes signs where
 * none belong and stops at the first character it does not like.
 */
#include "drehgeber/figure.h"

#include "drehgeber/text.h"

/* Longer texts are no numbers. */
#define LENGTH_MAX 4096u

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* A decimal on its way: `fraction` digits of it stood behind the point. */
struct decimal {
    int64_t value;
    unsigned fraction;
    bool point;
    bool any;
    bool cut;
};

/* Append a digit; false when the value would leave 64 bits. */
static bool push_digit(int64_t *value, int digit)
{
    if (*value > (INT64_MAX - digit) / 10) {
        return false;
    }
    *value = *value * 10 + digit;
    return true;
}

/* @return false: no such character belongs there, or the value would leave 64 bits */
static bool take_character(struct decimal *self, char c, unsigned places)
{
    if (c == '.' && !self->point) {
        self->point = true;
        return true;
    }
    if (!is_digit(c)) {
        return false;
    }
    self->any = true;
    /* Beyond the last place: noted, not rounded. */
    if (self->point && self->fraction == places) {
        self->cut = self->cut || c != '0';
        return true;
    }
    self->fraction += self->point ? 1u : 0u;
    return push_digit(&self->value, c - '0');
}

bool dg_decimal_parse(const char *text, size_t n, unsigned places, struct dg_decimal *out)
{
    struct decimal number = {.value = 0};
    const bool negative = n > 0 && text[0] == '-';

    for (size_t i = n > 0 && (text[0] == '-' || text[0] == '+') ? 1u : 0u; i < n; i++) {
        if (!take_character(&number, text[i], places)) {
            return false;
        }
    }
    /* "1.5" with 3 places is 1500. */
    for (; number.fraction < places; number.fraction++) {
        if (!push_digit(&number.value, 0)) {
            return false;
        }
    }
    out->value = negative ? -number.value : number.value;
    out->cut = number.cut;
    return number.any;
}

/* @return 0..15; 16: it is none */
static unsigned figure_digit_of(char c)
{
    const char small = (char)(c | 0x20);

    if (is_digit(c)) {
        return (unsigned)(c - '0');
    }
    return small >= 'a' && small <= 'f' ? (unsigned)(small - 'a') + 10u : 16u;
}

bool dg_unsigned_parse(const char *text, uint64_t *out)
{
    size_t n = dg_text_length(text, LENGTH_MAX);
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
        const unsigned digit = figure_digit_of(text[i]);
        if (digit >= base || value > (UINT64_MAX - digit) / base) {
            return false;
        }
        value = value * base + digit;
    }
    *out = value;
    return n > 0 && n < LENGTH_MAX;
}

int64_t dg_power_of_ten(unsigned places)
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

dg_angle dg_angle_of_degrees(int64_t value, unsigned places)
{
    const uint64_t den = 360u * (uint64_t)dg_power_of_ten(places);
    if (value >= 0) {
        return scale_up((uint64_t)value, den);
    }
    return -(int64_t)dg_muldiv((uint64_t)-value, (uint64_t)DG_TURN, den);
}
