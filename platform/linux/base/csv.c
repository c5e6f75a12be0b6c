/* SPDX-License-Identifier: MIT */
/*
 * Points over time, a line at a time. Strict where a mistake would bend the motion (order, units,
 * exponents), lenient where tools differ (header, blanks, line ends, digits beyond use).
 */
#define _GNU_SOURCE
#include "csv.h"

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/figure.h"

/* 1 ns of time; an angle far below its own unit of 8e-8 degree. */
#define PLACES 9u
#define TIME_MAX_S 9000000000
#define ANGLE_MAX (6000000000 * 1000000000)

static void put_angle(void *points, size_t index, dg_ns at, int64_t value)
{
    struct dg_motion_point *to = points;
    to[index] = (struct dg_motion_point){at, dg_angle_of_degrees(value, PLACES)};
}

const struct lx_csv_kind lx_csv_motion = {
    .column = "angle_deg",
    .value = {"the angle is decimal degrees within +-6000000000"},
    .places = PLACES,
    .min = -ANGLE_MAX,
    .max = ANGLE_MAX,
    .size = sizeof(struct dg_motion_point),
    .put = put_angle,
};

/* Where the reader is, and what it has. */
struct lx_csv {
    FILE *file;
    char *name; /* owned */
    struct lx_csv_kind kind;
    unsigned long line;
    bool started; /* the first line that is not empty or a comment has been seen */
    size_t capacity;
    size_t most; /* points */
    struct lx_csv_points found;
    dg_ns latest;                    /* time of the last point */
    char text[LX_CSV_LINE_MAX + 2u]; /* of a line, with its end, CR LF at most; not a string */
};

/* A piece of a line. */
struct field {
    const char *at;
    size_t n;
};

static bool is_csv_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

static struct field trimmed(const char *at, size_t n)
{
    while (n > 0 && is_csv_blank(at[0])) {
        at++;
        n--;
    }
    while (n > 0 && is_csv_blank(at[n - 1])) {
        n--;
    }
    return (struct field){at, n};
}

/* A header is a first line that does not start like a number. */
static bool is_header(const struct lx_csv *self, struct field line)
{
    return !self->started && memchr("+-.0123456789", line.at[0], 13) == NULL;
}

static int refuse_line(const struct lx_csv *self, struct lx_error *error, const char *what,
                       struct field got)
{
    return lx_fail(error, "%s:%lu: %s, not '%.*s'", self->name, self->line, what,
                   (int)(got.n > 60 ? 60 : got.n), got.at);
}

static int complain_of_line(const struct lx_csv *self, struct lx_error *error, struct field got)
{
    struct lx_words what = {""};
    lx_words_add(&what, "a line is 'time_s,%s'", self->kind.column);
    return refuse_line(self, error, what.text, got);
}

static int append_point(struct lx_csv *self, dg_ns at, int64_t value, struct lx_error *error)
{
    if (self->found.count == self->most) {
        return lx_fail(error, "%s:%lu: more than %zu points", self->name, self->line, self->most);
    }
    if (self->found.count == self->capacity) {
        const size_t capacity = self->capacity == 0 ? 256 : self->capacity * 2;
        void *grown = reallocarray(self->found.points, capacity, self->kind.size);
        if (grown == NULL) {
            return lx_fail(error, "%s:%lu: no memory for so many lines", self->name, self->line);
        }
        self->found.points = grown;
        self->capacity = capacity;
    }
    self->kind.put(self->found.points, self->found.count++, at, value);
    self->latest = at;
    return 0;
}

/* One line without its comment. */
static int take_csv_point(struct lx_csv *self, struct field line, struct lx_error *error)
{
    const struct lx_csv_kind *kind = &self->kind;
    const char *comma = memchr(line.at, ',', line.n);
    /* A second comma ends up in the value and is refused there. */
    if (comma == NULL) {
        return complain_of_line(self, error, line);
    }
    const struct field time = trimmed(line.at, (size_t)(comma - line.at));
    const struct field second = trimmed(comma + 1, line.n - (size_t)(comma + 1 - line.at));
    struct dg_decimal at;
    struct dg_decimal value;
    if (!dg_decimal_parse(time.at, time.n, PLACES, &at) || at.value < 0 ||
        at.value > TIME_MAX_S * dg_power_of_ten(PLACES)) {
        return refuse_line(self, error, "the time is decimal seconds from 0 to 9000000000", time);
    }
    if (!dg_decimal_parse(second.at, second.n, kind->places, &value) || value.value < kind->min ||
        value.value > kind->max) {
        return refuse_line(self, error, kind->value.text, second);
    }
    /* The core needs them in order; the nanoseconds count, not the digits. */
    const bool again = self->found.count > 0 && self->latest == (dg_ns)at.value;
    if ((again && !kind->steps) || self->latest > (dg_ns)at.value) {
        return refuse_line(self, error,
                           kind->steps ? "the time must not be earlier than on the line before"
                                       : "the time must be later than on the line before",
                           time);
    }
    return append_point(self, (dg_ns)at.value, value.value, error);
}

static int take_csv_line(struct lx_csv *self, size_t n, struct lx_error *error)
{
    static const char mark[] = "\xEF\xBB\xBF"; /* of UTF-8; some tools begin a file with it */
    const char *text = self->text;
    if (self->line == 1 && n >= 3 && memcmp(text, mark, 3) == 0) {
        text += 3;
        n -= 3;
    }
    const char *comment = memchr(text, '#', n);
    const struct field line = trimmed(text, comment == NULL ? n : (size_t)(comment - text));
    if (line.n == 0) {
        return 0;
    }
    const bool header = is_header(self, line);
    self->started = true;
    return header ? 0 : take_csv_point(self, line, error);
}

struct lx_csv *lx_csv_begin(FILE *file, const char *name, const struct lx_csv_kind *kind,
                            size_t most)
{
    struct lx_csv *self = calloc(1, sizeof *self);
    char *copy = strdup(name);
    if (self == NULL || copy == NULL) {
        free(self);
        free(copy);
        (void)fclose(file);
        return NULL;
    }
    self->file = file;
    self->name = copy;
    self->kind = *kind;
    self->most = most;
    return self;
}

struct lx_csv *lx_csv_open(const char *path, const struct lx_folder *folder,
                           const struct lx_csv_kind *kind, struct lx_error *error)
{
    FILE *file = lx_file_read(folder, path, error);
    if (file == NULL) {
        return NULL;
    }
    struct lx_csv *self =
        lx_csv_begin(file, path, kind, folder == NULL ? SIZE_MAX : LX_CSV_CLIENT_MAX);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory for its lines", path);
    }
    return self;
}

/* Of a line without its end. */
static int line_length_of(const char *text, int n)
{
    n -= n > 0 && text[n - 1] == '\n';
    return n - (n > 0 && text[n - 1] == '\r');
}

/* A line with its end. What has none in time, or is no text, may be a file of any length: it is not
   read on. @return its length; 0: there is none; -1 with `error` */
static int read_csv_line(struct lx_csv *self, struct lx_error *error)
{
    int n = 0;
    int c = ' ';
    while (c != '\n' && c != '\0' && n < (int)sizeof self->text &&
           (c = getc_unlocked(self->file)) != EOF) {
        self->text[n++] = (char)c;
    }
    if (c == EOF && ferror(self->file) != 0) {
        return lx_fail(error, "%s: cannot read: %s", self->name, strerror(errno));
    }
    if (c == '\0') {
        return lx_refuse(error, "expected lines of text", "%s:%lu: no text, as it has a NUL",
                         self->name, self->line + 1);
    }
    if (line_length_of(self->text, n) > (int)LX_CSV_LINE_MAX) {
        return lx_refuse(error, "expected a shorter line of text",
                         "%s:%lu: more than %u characters", self->name, self->line + 1,
                         LX_CSV_LINE_MAX);
    }
    return n;
}

/* Behind the last line. */
static int check_count(const struct lx_csv *self, struct lx_error *error)
{
    return self->found.count > 0 ? 0
                                 : lx_fail(error, "%s:%lu: no points; a line is 'time_s,%s'",
                                           self->name, self->line + 1, self->kind.column);
}

int lx_csv_read_on(struct lx_csv *self, unsigned lines, struct lx_error *error)
{
    for (unsigned i = 0; i < lines; i++) {
        const int n = read_csv_line(self, error);
        if (n <= 0) {
            return n < 0 ? -1 : check_count(self, error);
        }
        self->line++;
        if (take_csv_line(self, (size_t)n, error) != 0) {
            return -1;
        }
    }
    return 1;
}

struct lx_csv_points lx_csv_take(struct lx_csv *self)
{
    const struct lx_csv_points found = self->found;
    self->found = (struct lx_csv_points){.points = NULL};
    return found;
}

void lx_csv_close(struct lx_csv *self)
{
    if (self == NULL) {
        return;
    }
    (void)fclose(self->file);
    free(self->found.points);
    free(self->name);
    free(self);
}
