/* SPDX-License-Identifier: MIT */
#include "explain_source.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* So much of a file says what it is. */
#define HEAD 512u
#define DIGITS_MAX 18u
#define HEX_MAX 16u
#define DECIMALS 9u
/* More would not fit 64 bits of nanoseconds. */
#define SECONDS_MAX UINT64_C(10000000000)

/* --- lines --- */

/* Move what is left to the front, and read on. */
static void fill_room(struct explain_text *self)
{
    memmove(self->room, self->room + self->begin, self->end - self->begin);
    self->end -= self->begin;
    self->begin = 0;
    const size_t n = fread(self->room + self->end, 1, EXPLAIN_LINE_MAX, self->file);
    self->over = n == 0;
    self->end += n;
}

/* A line of `n` characters that stands at `begin`. */
static int take_text_line(struct explain_text *self, size_t n, struct lx_error *error)
{
    char *line = self->room + self->begin;
    self->line = line;
    self->token = line;
    const char *zero = memchr(line, '\0', n);
    if (zero != NULL) {
        return explain_text_refuse(self, zero, "a zero byte", "expected text", error);
    }
    self->begin += n + 1u;
    self->begin = self->begin < self->end ? self->begin : self->end;
    n -= n > 0 && line[n - 1u] == '\r' ? 1u : 0u;
    line[n] = '\0';
    return 1;
}

int explain_text_next(struct explain_text *self, struct lx_error *error)
{
    self->offset += self->line == NULL ? 0 : (uint64_t)(self->room + self->begin - self->line);
    self->line = NULL;
    for (;;) {
        const size_t n = self->end - self->begin;
        const char *end = memchr(self->room + self->begin, '\n', n);
        if (end != NULL) {
            return take_text_line(self, (size_t)(end - self->room) - self->begin, error);
        }
        if (self->over) {
            return n == 0 ? 0 : take_text_line(self, n, error);
        }
        if (n >= EXPLAIN_LINE_MAX - 1u) {
            self->line = self->room + self->begin;
            return explain_text_refuse(self, self->line, "a line without an end",
                                       "expected lines of less than 4096 characters", error);
        }
        fill_room(self);
    }
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

size_t explain_text_token(struct explain_text *self, const char **token)
{
    const char *at = self->token;
    while (is_blank(*at)) {
        at++;
    }
    *token = at;
    while (*at != '\0' && !is_blank(*at)) {
        at++;
    }
    self->token = at;
    return (size_t)(at - *token);
}

int explain_text_refuse(const struct explain_text *self, const char *at, const char *what,
                        const char *right, struct lx_error *error)
{
    const uint64_t offset = self->offset + (self->line == NULL ? 0 : (uint64_t)(at - self->line));
    return lx_refuse(error, right, "%s:%" PRIu64 ": %s", self->path, offset, what);
}

size_t explain_number(const char *at, size_t n, uint64_t *value)
{
    size_t i = 0;
    *value = 0;
    for (; i < n && at[i] >= '0' && at[i] <= '9'; i++) {
        if (i == DIGITS_MAX) {
            return 0;
        }
        *value = *value * 10u + (uint64_t)(at[i] - '0');
    }
    return i;
}

size_t explain_seconds(const char *at, size_t n, dg_ns *value)
{
    uint64_t seconds;
    dg_ns part = 0;
    size_t used = explain_number(at, n, &seconds);
    if (used == 0 || seconds >= SECONDS_MAX) {
        return 0;
    }
    if (used < n && at[used] == '.') {
        dg_ns unit = DG_S(1);
        for (used++; used < n && at[used] >= '0' && at[used] <= '9'; used++) {
            unit /= 10u; /* 0 behind the ninth */
            part += unit * (dg_ns)(at[used] - '0');
        }
    }
    *value = DG_S(1) * seconds + part;
    return used;
}

size_t explain_hex(const char *at, size_t n, uint64_t *value)
{
    size_t i = 0;
    *value = 0;
    for (; i < n; i++) {
        static const char digits[] = "0123456789ABCDEF0123456789abcdef";
        const char *digit = at[i] == '\0' ? NULL : strchr(digits, at[i]);
        if (digit == NULL) {
            break;
        }
        if (i == HEX_MAX) {
            return 0;
        }
        *value = *value << 4 | (uint64_t)((digit - digits) % 16);
    }
    return i;
}

/* --- recordings --- */

const struct explain_format *const explain_formats[] = {
    &explain_pcap, &explain_sr, &explain_vcd, &explain_candump, &explain_serial,
};
const size_t explain_format_count = DG_COUNT(explain_formats);

static const struct explain_format *find_format(FILE *file)
{
    uint8_t head[HEAD];
    const size_t n = fread(head, 1, sizeof head, file);
    if (ferror(file) != 0 || fseek(file, 0, SEEK_SET) != 0) {
        return NULL;
    }
    for (size_t i = 0; i < explain_format_count; i++) {
        if (explain_formats[i]->begins(head, n)) {
            return explain_formats[i];
        }
    }
    return NULL;
}

struct explain_source *explain_source_open(FILE *file, const char *path, struct lx_error *error)
{
    const struct explain_format *format = find_format(file);
    if (format == NULL) {
        (void)lx_refuse(
            error, "expected a candump log, pcapng, pcap, VCD, a session of sigrok or a serial log",
            "%s:0: not a known kind of recording", path);
        return NULL;
    }
    struct explain_source *self = lx_allocate(format->size, "a recording", error);
    if (self == NULL) {
        return NULL;
    }
    self->format = format;
    self->text.file = file;
    self->text.path = path;
    self->uart = (struct dg_host_uart){.baud = 9600, .parity = 'E'};
    if (format->open != NULL && format->open(self, error) != 0) {
        explain_source_close(self);
        return NULL;
    }
    return self;
}

int explain_source_next(struct explain_source *self, struct dg_tap_event *to,
                        struct lx_error *error)
{
    const int found = self->format->next(self, to, error);
    if (found == 0 && ferror(self->text.file) != 0) {
        return explain_text_refuse(&self->text, self->text.line, "it cannot be read",
                                   "expected a file", error);
    }
    return found;
}

void explain_source_close(struct explain_source *self)
{
    if (self != NULL && self->format->close != NULL) {
        self->format->close(self);
    }
    free(self);
}

void explain_source_stamp(struct explain_source *self, dg_ns at, struct dg_tap_event *to)
{
    self->now = at > self->now ? at : self->now;
    to->at = self->now;
}
