/* SPDX-License-Identifier: MIT */
/*
 * Parameters but for numbers: words, flags and strings (IEEE 488.2 7.7).
 */
#include "scpi_private.h"

#include <string.h>

#define FLAGS 4u

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

static bool is_quote(char c)
{
    return c == '"' || c == '\'';
}

bool dg_scpi_is_end(char c)
{
    return c == '\0' || c == ';';
}

void dg_scpi_skip_blanks(struct dg_scpi *self)
{
    while (is_blank(self->line[self->at])) {
        self->at++;
    }
}

size_t dg_scpi_token(const struct dg_scpi *self)
{
    const char *const begin = &self->line[self->at];
    const char *at = begin;

    while (!dg_scpi_is_end(*at) && *at != ',' && !is_blank(*at)) {
        at++;
    }
    return (size_t)(at - begin);
}

bool dg_scpi_more(struct dg_scpi *self)
{
    dg_scpi_skip_blanks(self);
    return !self->failed && !dg_scpi_is_end(self->line[self->at]);
}

bool dg_scpi_next(struct dg_scpi *self)
{
    if (self->failed) {
        return false;
    }
    dg_scpi_skip_blanks(self);
    if (!self->first && self->line[self->at] == ',') {
        self->at++;
        dg_scpi_skip_blanks(self);
    }
    self->first = false;
    if (dg_scpi_token(self) == 0) {
        dg_scpi_raise_usage(self, DG_SCPI_MISSING);
        return false;
    }
    return true;
}

/* Raise `code` with what stands at the place. */
static void refuse_token(struct dg_scpi *self, int code)
{
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    dg_text_add_n(&detail, &self->line[self->at], dg_scpi_token(self));
    dg_scpi_raise(self, code, detail.to);
}

/* What stands behind a blank is a parameter more, or none at all. */
static void refuse_apart(struct dg_scpi *self)
{
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);
    const bool several = dg_scpi_count(self->command->parameters) > 1u;

    dg_text_add_n(&detail, &self->line[self->at], dg_scpi_token(self));
    dg_text_add(&detail, several ? "; a comma is missing, expected " : "; expected ");
    dg_scpi_add_usage(&detail, self->command, self->query);
    dg_scpi_raise(self, DG_SCPI_SYNTAX, detail.to);
}

bool dg_scpi_close(struct dg_scpi *self, int code)
{
    const bool apart = is_blank(self->line[self->at]);

    dg_scpi_skip_blanks(self);
    if (dg_scpi_token(self) == 0) {
        return true;
    }
    if (apart) {
        refuse_apart(self);
    } else {
        refuse_token(self, code);
    }
    return false;
}

unsigned dg_scpi_count(const char *text)
{
    unsigned count = 1;
    char quote = '\0'; /* that ends the string at hand */

    while (is_blank(*text)) {
        text++;
    }
    if (dg_scpi_is_end(*text)) {
        return 0;
    }
    for (; *text != '\0' && (quote != '\0' || *text != ';'); text++) {
        if (*text == quote) {
            quote = '\0';
        } else if (quote == '\0' && is_quote(*text)) {
            quote = *text;
        } else if (quote == '\0') {
            count += *text == ',' ? 1u : 0u;
        }
    }
    return count;
}

bool dg_scpi_word(struct dg_scpi *self, const char *const *words, size_t count, size_t *index)
{
    if (!dg_scpi_next(self)) {
        return false;
    }
    const size_t n = dg_scpi_token(self);
    for (size_t i = 0; i < count; i++) {
        if (dg_scpi_is_form(words[i], dg_scpi_length(words[i]), &self->line[self->at], n)) {
            *index = i;
            self->at = (uint16_t)(self->at + n);
            return true;
        }
    }
    dg_scpi_refuse_word(self, DG_SCPI_ILLEGAL, words, count);
    return false;
}

bool dg_scpi_at_word(const struct dg_scpi *self)
{
    const char *at = &self->line[self->at];

    while (is_blank(*at) || (*at == ',' && !self->first)) {
        at++;
    }
    return (*at >= 'A' && *at <= 'Z') || (*at >= 'a' && *at <= 'z');
}

bool dg_scpi_flag(struct dg_scpi *self, bool *value)
{
    static const char *const flags[FLAGS] = {"OFF", "ON", "0", "1"};
    size_t index;

    if (!dg_scpi_word(self, flags, FLAGS, &index) || !dg_scpi_close(self, DG_SCPI_SYNTAX)) {
        return false;
    }
    *value = (index & 1u) != 0;
    return true;
}

/* The next character of a string, which a doubled quote is, too. @return false: there is none */
static bool next_of_string(struct dg_scpi *self, char quote, char *out)
{
    *out = self->line[self->at];
    if (*out == '\0') {
        dg_scpi_raise(self, DG_SCPI_STRING, "no closing quote");
        return false;
    }
    self->at++;
    if (*out != quote) {
        return true;
    }
    const bool doubled = self->line[self->at] == quote;
    self->at = (uint16_t)(self->at + (doubled ? 1u : 0u));
    return doubled;
}

/* @return how long the text is, which may be more than fits; likewise the next one */
static size_t read_string(struct dg_scpi *self, char *to, size_t size)
{
    const char quote = self->line[self->at];
    size_t n = 0;
    char c;

    self->at++;
    while (next_of_string(self, quote, &c)) {
        if (n + 1u < size) {
            to[n] = c;
            to[n + 1u] = '\0';
        }
        n++;
    }
    return n;
}

static size_t read_bare(struct dg_scpi *self, char *to, size_t size)
{
    const size_t n = dg_scpi_token(self);
    const size_t fits = n < size ? n : size - 1u;

    memcpy(to, &self->line[self->at], fits);
    to[fits] = '\0';
    self->at = (uint16_t)(self->at + n);
    return n;
}

static void raise_too_long(struct dg_scpi *self, size_t most)
{
    static const char before[] = "at most ";
    static const char after[] = " characters";
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);
    char digits[DG_TEXT_DIGITS_MAX];

    dg_text_add(&detail, before);
    dg_text_add_n(&detail, digits, dg_text_digits(digits, most, false, 0));
    dg_text_add(&detail, after);
    dg_scpi_raise(self, DG_SCPI_RANGE, detail.to);
}

bool dg_scpi_text(struct dg_scpi *self, char *to, size_t size)
{
    to[0] = '\0';
    if (!dg_scpi_next(self)) {
        return false;
    }
    const bool quoted = is_quote(self->line[self->at]);
    const size_t n = quoted ? read_string(self, to, size) : read_bare(self, to, size);
    if (self->failed || !dg_scpi_close(self, DG_SCPI_STRING)) {
        return false;
    }
    if (n >= size) {
        raise_too_long(self, size - 1u);
        return false;
    }
    return true;
}
