/* SPDX-License-Identifier: MIT */
/*
 * Sessions of sigrok and PulseView: a zip file with `metadata`, which names signals and the rate of
 * samples, and with samples in logic-1, or in logic-1-1, logic-1-2 and so on. The n-th probe is bit
 * n - 1 of a sample, whose first byte has the lowest bits.
 *
 * libzip unpacks them. It is loaded when such a file is opened, as libpcap is. It keeps the
 * directory of the file in memory; a directory that is larger than any of sigrok's is refused.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <inttypes.h>
#include <string.h>
#include <unistd.h>

#include "drehgeber/bits.h"
#include "explain_levels.h"

#define LIBRARY "libzip.so.4"
#define LIBRARY_ELSEWHERE "libzip.so.5"
#define BUFFER 16384u
#define NAME_MAX 64u
#define MEMBER_MAX 80u
#define UNIT_MAX 8u
#define RATE_MAX UINT64_C(10000000000)
/* The end of a zip file without a comment: a mark, and the size of the directory at 12. */
#define END_SIZE 22
#define END_MARK 0x06054B50u
#define DIRECTORY_AT 12u
#define DIRECTORY_MAX (1u << 20)

/* Functions of the library. */
struct library {
    void *(*open)(int fd, int flags, int *why);
    int64_t (*locate)(void *zip, const char *name, uint32_t flags);
    void *(*open_member)(void *zip, uint64_t index, uint32_t flags);
    int64_t (*read)(void *member, void *to, uint64_t n);
    int (*close_member)(void *member);
    void (*discard)(void *zip);
};

#define AT(member) offsetof(struct library, member)
static const struct {
    const char *name;
    size_t at;
} functions[] = {
    {"zip_fdopen", AT(open)},
    {"zip_name_locate", AT(locate)},
    {"zip_fopen_index", AT(open_member)},
    {"zip_fread", AT(read)},
    {"zip_fclose", AT(close_member)},
    {"zip_discard", AT(discard)},
};
_Static_assert(sizeof(struct library) == DG_COUNT(functions) * sizeof(void (*)(void)),
               "a row for each function");

struct session {
    struct explain_source source;
    void *loaded; /* the library */
    struct library library;
    void *zip;
    void *member;        /* that is being read; NULL: none */
    unsigned part;       /* its number; 0: logic-1 itself */
    char name[NAME_MAX]; /* "logic-1" */
    uint64_t rate;       /* samples in a second */
    size_t unit;         /* bytes of a sample */
    unsigned probes[EXPLAIN_SIDES];
    uint64_t index; /* of the next sample */
    bool over;
    struct explain_levels levels;
    size_t begin; /* of what is not used yet, in `buffer` */
    size_t end;
    uint8_t buffer[BUFFER];
};

static bool begins(const uint8_t *bytes, size_t n)
{
    return n >= 4u && memcmp(bytes, "PK\x03\x04", 4) == 0;
}

static int refuse_sample(const struct session *self, const char *what, const char *right,
                         struct lx_error *error)
{
    return lx_refuse(error, right, "%s:0: %s, in sample %" PRIu64, self->source.text.path, what,
                     self->index);
}

/* --- the file --- */

static int load_libzip(struct session *self, struct lx_error *error)
{
    self->loaded = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (self->loaded == NULL) {
        self->loaded = dlopen(LIBRARY_ELSEWHERE, RTLD_NOW | RTLD_LOCAL);
    }
    if (self->loaded == NULL) {
        return lx_refuse(error, "expected libzip (Debian: libzip4)",
                         "%s: no libzip, which unpacks such files", self->source.text.path);
    }
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        const void *found = dlsym(self->loaded, functions[i].name);
        if (found == NULL) {
            return lx_refuse(error, "expected libzip 1.0 or newer", "%s: libzip has no %s",
                             self->source.text.path, functions[i].name);
        }
        memcpy((char *)&self->library + functions[i].at, &found, sizeof found);
    }
    return 0;
}

static bool has_small_directory(FILE *file)
{
    uint8_t end[END_SIZE];
    return fseek(file, -END_SIZE, SEEK_END) == 0 && fread(end, 1, sizeof end, file) == sizeof end &&
           dg_load_le32(end) == END_MARK && dg_load_le32(end + DIRECTORY_AT) <= DIRECTORY_MAX;
}

/* @return whether there is such a member, which is opened */
static bool open_member(struct session *self, const char *name)
{
    const int64_t index = self->library.locate(self->zip, name, 0);
    self->member = index < 0 ? NULL : self->library.open_member(self->zip, (uint64_t)index, 0);
    return self->member != NULL;
}

static void close_member(struct session *self)
{
    if (self->member != NULL) {
        (void)self->library.close_member(self->member);
        self->member = NULL;
    }
}

/* --- what it says of itself --- */

/* "1 MHz", "12.5 kHz" */
static uint64_t parse_rate(const char *at, size_t n)
{
    static const struct {
        const char *name;
        uint64_t factor;
    } units[] = {{"Hz", 1}, {"kHz", 1000}, {"MHz", 1000000}, {"GHz", 1000000000}};
    dg_ns value;
    const size_t used = explain_seconds(at, n, &value);
    at += used;
    n -= used;
    const size_t blank = n > 0 && *at == ' ' ? 1u : 0u;
    for (size_t i = 0; used > 0 && i < DG_COUNT(units); i++) {
        const bool same = strlen(units[i].name) == n - blank &&
                          strncmp(at + blank, units[i].name, n - blank) == 0;
        if (same && value <= UINT64_MAX / units[i].factor) {
            return value * units[i].factor / DG_S(1);
        }
    }
    return 0;
}

/* "probe2=reply" */
static void take_probe(struct session *self, const char *number, size_t digits, const char *name,
                       size_t n)
{
    uint64_t probe;
    const enum explain_side side = explain_levels_find(&self->levels, name, n);
    if (side != EXPLAIN_SIDES && explain_number(number, digits, &probe) == digits && probe > 0 &&
        probe <= 8u * (uint64_t)UNIT_MAX) {
        self->probes[side] = (unsigned)probe - 1u;
    } else if (side != EXPLAIN_SIDES) {
        self->levels.signals[side].found = false;
    }
}

static bool is_key(const char *line, size_t n, const char *key)
{
    return strlen(key) == n && strncmp(line, key, n) == 0;
}

static void take_metadata_line(struct session *self, const char *line, size_t n)
{
    const char *sign = memchr(line, '=', n);
    const size_t key = sign == NULL ? 0 : (size_t)(sign - line);
    const char *value = line + key + 1u;
    const size_t length = sign == NULL ? 0 : n - key - 1u;
    uint64_t number;
    if (is_key(line, key, "capturefile") && length < NAME_MAX) {
        memcpy(self->name, value, length);
        self->name[length] = '\0';
    } else if (is_key(line, key, "samplerate")) {
        self->rate = parse_rate(value, length);
    } else if (is_key(line, key, "unitsize") && explain_number(value, length, &number) == length) {
        self->unit = number <= UNIT_MAX ? (size_t)number : 0;
    } else if (key > strlen("probe") && strncmp(line, "probe", strlen("probe")) == 0) {
        take_probe(self, line + strlen("probe"), key - strlen("probe"), value, length);
    }
}

static void take_metadata(struct session *self, const char *text, size_t n)
{
    while (n > 0) {
        const char *end = memchr(text, '\n', n);
        const size_t length = end == NULL ? n : (size_t)(end - text);
        take_metadata_line(self, text, length);
        n -= end == NULL ? length : length + 1u;
        text += length + 1u;
    }
}

static int check_metadata(const struct session *self, struct lx_error *error)
{
    if (!explain_levels_whole(&self->levels)) {
        return refuse_sample(self, "no wire", explain_levels_right, error);
    }
    if (self->rate == 0 || self->rate > RATE_MAX || self->unit == 0 || self->name[0] == '\0') {
        return refuse_sample(self, "no samples",
                             "expected capturefile, samplerate and unitsize of 1 to 8", error);
    }
    for (size_t i = 0; i < EXPLAIN_SIDES; i++) {
        if (self->probes[i] >= 8u * self->unit) {
            return refuse_sample(self, "a probe that no sample has",
                                 "expected probes that fit the unitsize", error);
        }
    }
    return 0;
}

static int read_metadata(struct session *self, struct lx_error *error)
{
    if (!open_member(self, "metadata")) {
        return refuse_sample(self, "no session of sigrok", "expected a member 'metadata'", error);
    }
    const int64_t n = self->library.read(self->member, self->buffer, sizeof self->buffer);
    close_member(self);
    if (n < 0 || n == (int64_t)sizeof self->buffer) {
        return refuse_sample(self, "metadata that cannot be read",
                             "expected less than 16384 characters", error);
    }
    take_metadata(self, (const char *)self->buffer, (size_t)n);
    return check_metadata(self, error);
}

static int open_session(struct explain_source *source, struct lx_error *error)
{
    struct session *self = (struct session *)source;
    int why = 0;
    source->sided = true;
    if (load_libzip(self, error) != 0) {
        return -1;
    }
    if (!has_small_directory(source->text.file)) {
        return refuse_sample(self, "no zip file of sigrok",
                             "expected a directory of up to a megabyte", error);
    }
    const int fd = dup(fileno(source->text.file));
    self->zip = fd < 0 ? NULL : self->library.open(fd, 0, &why); /* has its own of it then */
    if (self->zip == NULL) {
        if (fd >= 0) {
            (void)close(fd);
        }
        return refuse_sample(self, "no zip file", "expected a session of sigrok", error);
    }
    return read_metadata(self, error);
}

/* --- samples --- */

/* The next member with samples. */
static bool open_part(struct session *self)
{
    char name[MEMBER_MAX];
    close_member(self);
    if (self->part == 0 && open_member(self, self->name)) {
        self->part = UINT32_MAX; /* there are no others */
        return true;
    }
    if (self->part == UINT32_MAX) {
        return false;
    }
    self->part++;
    (void)snprintf(name, sizeof name, "%s-%u", self->name, self->part);
    return open_member(self, name);
}

/* @return 1: there is a whole sample; 0: it is all over; -1 */
static int fill_samples(struct session *self, struct lx_error *error)
{
    while (self->end - self->begin < self->unit) {
        if (self->member == NULL && !open_part(self)) {
            return 0;
        }
        memmove(self->buffer, self->buffer + self->begin, self->end - self->begin);
        self->end -= self->begin;
        self->begin = 0;
        const int64_t n = self->library.read(self->member, self->buffer + self->end,
                                             sizeof self->buffer - self->end);
        if (n < 0) {
            return refuse_sample(self, "samples that cannot be unpacked", "expected a whole member",
                                 error);
        }
        self->end += (size_t)n;
        if (n == 0) {
            close_member(self);
            if (self->part == UINT32_MAX) {
                return 0;
            }
        }
    }
    return 1;
}

static bool level_of(const struct session *self, enum explain_side side)
{
    const unsigned probe = self->probes[side];
    return (self->buffer[self->begin + probe / 8u] >> probe % 8u & 1u) != 0;
}

/* A sample. What a change of levels has ended waits in self->levels. */
static void take_sample(struct session *self)
{
    const bool first = level_of(self, EXPLAIN_FIRST);
    const bool second = level_of(self, EXPLAIN_SECOND);
    struct explain_levels *levels = &self->levels;
    if (first != levels->signals[EXPLAIN_FIRST].level ||
        second != levels->signals[EXPLAIN_SECOND].level) {
        const dg_ns at = DG_S(1) * (self->index / self->rate) +
                         DG_S(1) * (self->index % self->rate) / self->rate;
        if (at > levels->now) {
            explain_levels_advance(levels, &self->source.uart, at);
        }
        levels->now = at;
        explain_levels_change(levels, EXPLAIN_FIRST, first);
        explain_levels_change(levels, EXPLAIN_SECOND, second);
    }
    self->begin += self->unit;
    self->index++;
}

static int next(struct explain_source *source, struct dg_tap_event *to, struct lx_error *error)
{
    struct session *self = (struct session *)source;
    while (!explain_levels_take(&self->levels, to)) {
        const int found = self->over ? 0 : fill_samples(self, error);
        if (found < 0 || self->over) {
            return found;
        }
        if (found == 0) {
            explain_levels_advance(&self->levels, &source->uart, DG_NEVER);
            self->over = true;
        } else {
            take_sample(self);
        }
    }
    explain_source_stamp(source, to->at, to);
    return 1;
}

static void close_session(struct explain_source *source)
{
    struct session *self = (struct session *)source;
    if (self->zip != NULL) {
        close_member(self);
        self->library.discard(self->zip);
    }
    if (self->loaded != NULL) {
        (void)dlclose(self->loaded);
    }
}

const struct explain_format explain_sr = {
    .name = "sigrok",
    .begins = begins,
    .size = sizeof(struct session),
    .open = open_session,
    .next = next,
    .close = close_session,
};
