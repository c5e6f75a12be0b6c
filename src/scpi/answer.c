/* SPDX-License-Identifier: MIT */
/*
 * Answers: parts with ',' between them, answers of one line with ';' between them (IEEE 488.2 8).
 */
#include "scpi_private.h"

#define DECIMAL 10u
#define NIBBLE_BITS 4u

void dg_scpi_write(struct dg_scpi *self, const char *text, size_t n)
{
    if (!self->failed && n > 0) {
        self->setup.ops->write(self->setup.ctx, text, n);
    }
}

void dg_scpi_begin(struct dg_scpi *self)
{
    if (dg_scpi_more(self)) { /* what was not understood in full is not answered */
        dg_scpi_raise_usage(self, DG_SCPI_SUPERFLUOUS);
    }
    if (self->put) {
        dg_scpi_append(self, ",");
    } else if (self->answered) {
        dg_scpi_append(self, ";");
    }
    self->put = true;
    self->answered = self->answered || !self->failed;
}

void dg_scpi_append(struct dg_scpi *self, const char *text)
{
    dg_scpi_write(self, text, dg_scpi_length(text));
}

void dg_scpi_append_quoted(struct dg_scpi *self, const char *text)
{
    const char *at = text;

    for (; *at != '\0'; at++) {
        if (*at == '"') { /* up to it and with it; it comes again with what follows */
            dg_scpi_write(self, text, (size_t)(at - text) + 1u);
            text = at;
        }
    }
    dg_scpi_write(self, text, (size_t)(at - text));
}

uint64_t dg_scpi_magnitude(int64_t value)
{
    return value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
}

size_t dg_scpi_format(char to[SCPI_DIGITS_MAX], uint64_t magnitude, bool negative, unsigned places)
{
    char backwards[SCPI_DIGITS_MAX];
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

static void append_decimal(struct dg_scpi *self, uint64_t magnitude, bool negative, unsigned places)
{
    char text[SCPI_DIGITS_MAX];

    dg_scpi_write(self, text, dg_scpi_format(text, magnitude, negative, places));
}

void dg_scpi_append_number(struct dg_scpi *self, int64_t value, unsigned places)
{
    append_decimal(self, dg_scpi_magnitude(value), value < 0, places);
}

void dg_scpi_append_hex(struct dg_scpi *self, uint64_t value, unsigned digits)
{
    static const char characters[] = "0123456789ABCDEF";

    while (digits > 0) {
        digits--;
        dg_scpi_write(self,
                      &characters[(value >> (NIBBLE_BITS * digits)) % (sizeof characters - 1u)], 1);
    }
}

void dg_scpi_put_number(struct dg_scpi *self, int64_t value, unsigned places)
{
    dg_scpi_begin(self);
    dg_scpi_append_number(self, value, places);
}

void dg_scpi_put_unsigned(struct dg_scpi *self, uint64_t value)
{
    dg_scpi_begin(self);
    append_decimal(self, value, false, 0);
}

void dg_scpi_put_word(struct dg_scpi *self, const char *text)
{
    dg_scpi_begin(self);
    dg_scpi_append(self, text);
}

void dg_scpi_put_string(struct dg_scpi *self, const char *text)
{
    dg_scpi_begin(self);
    dg_scpi_append(self, "\"");
    dg_scpi_append_quoted(self, text);
    dg_scpi_append(self, "\"");
}
