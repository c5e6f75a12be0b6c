/* SPDX-License-Identifier: MIT */
/*
 * Numbers as text.
 */
#include "drehgeber/text.h"

#define DECIMAL 10u
#define NIBBLE_BITS 4u

size_t dg_text_digits(char to[DG_TEXT_DIGITS_MAX], uint64_t magnitude, bool negative,
                      unsigned places)
{
    char backwards[DG_TEXT_DIGITS_MAX];
    size_t n = 0;
    unsigned digits = 0;

    do {
        backwards[n++] = (char)('0' + magnitude % DECIMAL);
        magnitude /= DECIMAL;
        digits++;
        if (digits == places) {
            backwards[n++] = '.';
        }
    } while (magnitude > 0 || digits <= places);
    if (negative) {
        backwards[n++] = '-';
    }
    for (size_t i = 0; i < n; i++) {
        to[i] = backwards[n - 1u - i];
    }
    return n;
}

void dg_text_add_number(struct dg_text *self, int64_t value)
{
    const uint64_t magnitude = value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
    char text[DG_TEXT_DIGITS_MAX];

    dg_text_add_n(self, text, dg_text_digits(text, magnitude, value < 0, 0));
}

void dg_text_add_hex(struct dg_text *self, uint64_t value, unsigned digits)
{
    static const char characters[] = "0123456789ABCDEF";

    while (digits > 0) {
        digits--;
        dg_text_add_n(self,
                      &characters[(value >> (NIBBLE_BITS * digits)) % (sizeof characters - 1u)], 1);
    }
}
