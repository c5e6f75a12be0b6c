/* SPDX-License-Identifier: MIT */
/*
 * What candump writes of a bus:
 *
 *   (1436509052.249713) vcan0 044#2A366C2BBA       -L, -l
 *   (1436509052.249713) vcan0 044#R8 T             -L -x
 *    (000.000123)  vcan0  TX - -  044   [5]  2A 36 6C 2B BA    on a terminal: time, direction,
 *     vcan0  044   [8]  remote request                         ... both may be missing
 *
 * Without times, frames are 1 ms apart.
 */
#include <string.h>

#include "explain_source.h"

#define ID_DIGITS 3u
#define STEP DG_MS(1)
#define DLC_MAX 8u
#define NAME_MAX 16u

struct candump {
    struct explain_source source;
    char wire[NAME_MAX]; /* the first one; frames of others are left out */
};

/* Letters, a bracket, blanks: no other format begins with them. */
static bool begins(const uint8_t *bytes, size_t n)
{
    size_t i = 0;
    while (i < n && (bytes[i] == ' ' || bytes[i] == '\n' || bytes[i] == '\r')) {
        i++;
    }
    const uint8_t first = i < n ? (uint8_t)(bytes[i] | 0x20u) : 0;
    return i < n && (bytes[i] == '(' || (first >= 'a' && first <= 'z'));
}

static int refuse_token(const struct candump *self, const char *at, const char *right,
                        struct lx_error *error)
{
    const bool end = *at == '\0';
    return explain_text_refuse(&self->source.text, at,
                               end ? "the line ends here" : "no frame of candump", right, error);
}

/* A data byte. */
static int take_byte(const struct candump *self, struct dg_can_frame *frame, const char *at,
                     size_t n, struct lx_error *error)
{
    uint64_t value;
    if (frame->dlc == DLC_MAX) {
        return refuse_token(self, at, "expected 8 bytes at most", error);
    }
    if (n < 2u || explain_hex(at, 2, &value) != 2u) {
        return refuse_token(self, at, "expected bytes of two hexadecimal digits", error);
    }
    frame->data[frame->dlc++] = (uint8_t)value;
    return 0;
}

/* Behind '#' of the compact form. */
static int take_compact(const struct candump *self, struct dg_can_frame *frame, const char *at,
                        const char *end, struct lx_error *error)
{
    if (at < end && *at == 'R') {
        const bool sized = at + 1 < end;
        frame->rtr = true;
        frame->dlc = sized ? (uint8_t)(at[1] - '0') : 0;
        return sized && (at[1] < '0' || at[1] > '8')
                   ? refuse_token(self, at + 1, "expected R and a length of 0 to 8", error)
                   : 0;
    }
    for (; at < end; at += 2) {
        at += *at == '.' ? 1 : 0;
        if (take_byte(self, frame, at, (size_t)(end - at), error) != 0) {
            return -1;
        }
    }
    return 0;
}

/* "[5]  2A 36 6C 2B BA", of which "[5]" is read already */
static int take_long(struct candump *self, struct dg_can_frame *frame, uint8_t length,
                     struct lx_error *error)
{
    const char *token;
    size_t n = explain_text_token(&self->source.text, &token);
    if (n == strlen("remote") && strncmp(token, "remote", n) == 0) {
        frame->rtr = true;
        frame->dlc = length;
        return 0;
    }
    for (; frame->dlc < length; n = explain_text_token(&self->source.text, &token)) {
        if (n != 2u) {
            return refuse_token(self, token, "expected as many bytes as the length says", error);
        }
        if (take_byte(self, frame, token, n, error) != 0) {
            return -1;
        }
    }
    return n == 0 || *token == '\''
               ? 0
               : refuse_token(self, token, "expected the end of the line", error);
}

/* An ID, of which encoders have those of 11 bits. @return 1; 0: another kind of frame; -1 */
static int take_id(const struct candump *self, struct dg_can_frame *frame, const char *at, size_t n,
                   struct lx_error *error)
{
    uint64_t id;
    const size_t digits = explain_hex(at, n, &id);
    if (digits != n || (digits != ID_DIGITS && digits != 8u)) {
        return refuse_token(self, at, "expected a CAN-ID of 3 or 8 hexadecimal digits", error);
    }
    if (digits == ID_DIGITS && id > 0x7FFu) {
        return refuse_token(self, at, "expected a CAN-ID of 000 to 7FF", error);
    }
    frame->id = (uint16_t)(id & 0x7FFu);
    return digits == ID_DIGITS ? 1 : 0;
}

/* The form of a terminal: `token` is the ID. @return as take_id() */
static int take_terminal_frame(struct candump *self, struct dg_can_frame *frame, const char *token,
                               size_t n, struct lx_error *error)
{
    const int kind = take_id(self, frame, token, n, error);
    uint64_t length;
    n = explain_text_token(&self->source.text, &token);
    if (kind < 0) {
        return -1;
    }
    if (n == 4u && token[0] == '[' && explain_number(token + 1, 2, &length) == 2u) {
        return 0; /* two digits: CAN FD */
    }
    if (n != 3u || token[0] != '[' || token[2] != ']' ||
        explain_number(token + 1, 1, &length) != 1u || length > DLC_MAX) {
        return refuse_token(self, token, "expected a length such as [8]", error);
    }
    return kind == 0 || take_long(self, frame, (uint8_t)length, error) == 0 ? kind : -1;
}

/* Behind the name of the wire. @return as take_id() */
static int take_candump_frame(struct candump *self, struct dg_can_frame *frame,
                              struct lx_error *error)
{
    const char *token;
    size_t n = explain_text_token(&self->source.text, &token);
    if (n == 2u && (token[0] == 'T' || token[0] == 'R') && token[1] == 'X') {
        (void)explain_text_token(&self->source.text, &token); /* flags: B, E */
        (void)explain_text_token(&self->source.text, &token);
        n = explain_text_token(&self->source.text, &token);
    }
    const char *sign = memchr(token, '#', n);
    if (sign == NULL) {
        return take_terminal_frame(self, frame, token, n, error);
    }
    const int kind = take_id(self, frame, token, (size_t)(sign - token), error);
    if (kind < 0 || kind == 0 || sign[1] == '#') {
        return kind < 0 ? -1 : 0;
    }
    return take_compact(self, frame, sign + 1, token + n, error) == 0 ? 1 : -1;
}

/* "(1436509052.249713)". `token` is what follows it. */
static int take_candump_time(struct candump *self, const char **token, size_t *n, dg_ns *at,
                             struct lx_error *error)
{
    struct explain_text *text = &self->source.text;
    *n = explain_text_token(text, token);
    *at = self->source.now + STEP;
    if (*n == 0 || (*token)[0] != '(') {
        return 0;
    }
    const size_t used = explain_seconds(*token + 1, *n - 1u, at);
    if (used == 0 || (*token)[used + 1u] != ')') {
        return refuse_token(self, *token, "expected a time such as (1436509052.249713)", error);
    }
    *n = explain_text_token(text, token);
    return 0;
}

/* Whether frames of this wire are the ones that are told. */
static bool is_wire(struct candump *self, const char *name, size_t n)
{
    if (self->wire[0] == '\0') {
        (void)snprintf(self->wire, sizeof self->wire, "%.*s", (int)n, name);
    }
    n = n < sizeof self->wire - 1u ? n : sizeof self->wire - 1u;
    return strlen(self->wire) == n && strncmp(self->wire, name, n) == 0;
}

/* @return 1; 0: a line without a frame for these encoders; -1 */
static int take_candump_line(struct candump *self, struct dg_tap_event *to, struct lx_error *error)
{
    const char *token;
    size_t n;
    dg_ns at;
    if (take_candump_time(self, &token, &n, &at, error) != 0) {
        return -1;
    }
    if (n == 0) {
        return *self->source.text.line == '\0'
                   ? 0
                   : refuse_token(self, token, "expected a wire", error);
    }
    *to = (struct dg_tap_event){.kind = DG_TAP_FRAME};
    const bool wanted = is_wire(self, token, n);
    const int found = take_candump_frame(self, &to->frame, error);
    if (found < 0) {
        return -1;
    }
    explain_source_stamp(&self->source, at, to);
    self->source.left_out += found > 0 && wanted ? 0 : 1u;
    return found > 0 && wanted ? 1 : 0;
}

static int next(struct explain_source *source, struct dg_tap_event *to, struct lx_error *error)
{
    struct candump *self = (struct candump *)source;
    int found;
    while ((found = explain_text_next(&source->text, error)) == 1) {
        const int frame = take_candump_line(self, to, error);
        if (frame != 0) {
            return frame;
        }
    }
    return found;
}

const struct explain_format explain_candump = {
    .name = "candump",
    .begins = begins,
    .size = sizeof(struct candump),
    .next = next,
};
