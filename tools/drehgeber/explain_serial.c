/* SPDX-License-Identifier: MIT */
/*
 * A serial log, as docs/explain.md has it: the moment at which the first character begins, who
 * sends, the characters without pauses between them. < and > are those of `run --verbose`.
 *
 *   # a comment
 *   9600 8E1                the line from here on; as encoders are delivered until then
 *   0.000000 < 40 42 02     to the encoder, in seconds since any moment
 *   0.012345 > 40 42 00 00 12 34 26
 */
#include <string.h>

#include "explain_source.h"

#define BAUD_MIN 100u
#define BAUD_MAX 10000000u

struct serial {
    struct explain_source source;
    dg_ns begin; /* of the next character */
    bool ours;
    bool inside; /* of a line with characters */
};

static bool begins(const uint8_t *bytes, size_t n)
{
    return n > 0 && (bytes[0] == '#' || (bytes[0] >= '0' && bytes[0] <= '9'));
}

/* "8E1" */
static bool take_character_frame(struct serial *self, const char *token, size_t n)
{
    if (n != 3u || token[0] != '8' || strchr("NEO", token[1]) == NULL || token[2] != '1') {
        return false;
    }
    self->source.uart.parity = (uint8_t)token[1];
    return true;
}

/* The line from now on. @return 0: nothing was said; -1 */
static int take_setting(struct serial *self, const char *at, uint64_t baud, struct lx_error *error)
{
    const char *token;
    const size_t n = explain_text_token(&self->source.text, &token);
    if (baud < BAUD_MIN || baud > BAUD_MAX) {
        return explain_text_refuse(&self->source.text, at, "no data rate of a line",
                                   "expected 100 to 10000000", error);
    }
    if (!take_character_frame(self, token, n)) {
        return explain_text_refuse(&self->source.text, token, "no setting of a line",
                                   "expected 8E1, 8O1 or 8N1", error);
    }
    self->source.uart.baud = (uint32_t)baud;
    return 0;
}

/* What stands before the characters. @return 0, or -1 */
static int take_head(struct serial *self, struct lx_error *error)
{
    struct explain_text *text = &self->source.text;
    const char *token;
    const char *sign;
    const size_t n = explain_text_token(text, &token);
    uint64_t baud;
    dg_ns at;
    self->inside = false;
    if (n == 0 || token[0] == '#') {
        return 0;
    }
    const char *rest = text->token;
    const size_t signs = explain_text_token(text, &sign);
    if (explain_number(token, n, &baud) == n && signs == 3u) {
        text->token = rest;
        return take_setting(self, token, baud, error);
    }
    if (explain_seconds(token, n, &at) != n) {
        return explain_text_refuse(text, token, "no time",
                                   "expected seconds such as 0.012345, or a line such as 9600 8E1",
                                   error);
    }
    if (signs != 1u || (*sign != '>' && *sign != '<')) {
        return explain_text_refuse(text, sign, "no direction",
                                   "expected < to the encoder, > from it", error);
    }
    self->begin = at > self->begin ? at : self->begin; /* the line is taken until then */
    self->ours = *sign == '>';
    self->inside = true;
    return 0;
}

/* @return 1; 0: there is none in this line; -1 */
static int take_character(struct serial *self, struct dg_tap_event *to, struct lx_error *error)
{
    const struct dg_host_uart *uart = &self->source.uart;
    const char *token;
    const size_t n = self->inside ? explain_text_token(&self->source.text, &token) : 0;
    uint64_t byte;
    if (n == 0 || *token == '#') {
        self->inside = false;
        return 0;
    }
    if (n != 2u || explain_hex(token, n, &byte) != n) {
        return explain_text_refuse(&self->source.text, token, "no character",
                                   "expected two hexadecimal digits such as 0A", error);
    }
    *to = (struct dg_tap_event){.kind = DG_TAP_CHARACTER, .ours = self->ours};
    to->character.baud = uart->baud;
    to->character.parity = (char)uart->parity;
    to->character.byte = (uint8_t)byte;
    self->begin += dg_host_uart_ns(uart, 1);
    explain_source_stamp(&self->source, self->begin, to);
    return 1;
}

static int next(struct explain_source *source, struct dg_tap_event *to, struct lx_error *error)
{
    struct serial *self = (struct serial *)source;
    for (;;) {
        const int character = take_character(self, to, error);
        if (character != 0) {
            return character;
        }
        const int found = explain_text_next(&source->text, error);
        if (found != 1 || take_head(self, error) != 0) {
            return found == 1 ? -1 : found;
        }
    }
}

static int open_log(struct explain_source *self, struct lx_error *error)
{
    (void)error;
    self->sided = true;
    return 0;
}

const struct explain_format explain_serial = {
    .name = "serial log",
    .begins = begins,
    .size = sizeof(struct serial),
    .open = open_log,
    .next = next,
};
