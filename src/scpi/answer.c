/* SPDX-License-Identifier: MIT */
/*
 * Answers: parts with ',' between them, answers of one line with ';' between them (IEEE 488.2 8).
 */
#include "scpi_private.h"

/* Those of 64 bits, and the zero behind them. */
#define HEX_SIZE 17u

/* What is written behind dg_scpi_begin(). */
static void write_quoted_text(struct dg_scpi *self, const char *text, size_t n)
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
    write_quoted_text(self, text, dg_scpi_length(text));
}

void dg_scpi_append_quoted(struct dg_scpi *self, const char *text)
{
    const char *at = text;

    for (; *at != '\0'; at++) {
        if (*at == '"') { /* up to it and with it; it comes again with what follows */
            write_quoted_text(self, text, (size_t)(at - text) + 1u);
            text = at;
        }
    }
    write_quoted_text(self, text, (size_t)(at - text));
}

uint64_t dg_scpi_magnitude(int64_t value)
{
    return value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
}

static void append_decimal(struct dg_scpi *self, uint64_t magnitude, bool negative, unsigned places)
{
    char text[DG_TEXT_DIGITS_MAX];

    write_quoted_text(self, text, dg_text_digits(text, magnitude, negative, places));
}

void dg_scpi_append_number(struct dg_scpi *self, int64_t value, unsigned places)
{
    append_decimal(self, dg_scpi_magnitude(value), value < 0, places);
}

void dg_scpi_append_hex(struct dg_scpi *self, uint64_t value, unsigned digits)
{
    char room[HEX_SIZE];
    struct dg_text text = dg_text_in(room, sizeof room);

    dg_text_add_hex(&text, value, digits);
    write_quoted_text(self, room, text.length);
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
