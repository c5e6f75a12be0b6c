/* SPDX-License-Identifier: MIT */
/*
 * A line for each sub-index of an EDS file: what it does, what it is called, what is noted of it.
 * The node has no use for names: they are looked up in the text.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "complain.h"
#include "eds_file.h"
#include "run.h"

/* Of names. */
#define NAME_MAX_TOLD 48
#define ROLE_WIDTH 11

static const char *const roles[] = {
    [DG_CO_SIMULATED] = "simulated",
    [DG_CO_STORES] = "stores",
    [DG_CO_CONSTANT] = "constant",
};
_Static_assert(DG_COUNT(roles) == DG_CO_ROLE_COUNT, "a word for each");

struct name {
    uint32_t key;
    const char *at; /* in the text */
    int n;
};

struct line {
    uint32_t key;
    const char *role;
    const char *remark; /* NULL: none */
};

struct explaining {
    struct eds_file *file;
    struct name *names; /* owned, likewise the next */
    struct line *lines;
    size_t name_count;
    size_t line_count;
};

/* At most so many digits. @return what stands behind them */
static const char *read_hex(const char *at, size_t most, uint32_t *value)
{
    char digits[5] = "";
    const size_t n = strspn(at, "0123456789abcdefABCDEF");
    memcpy(digits, at, n < most ? n : most);
    *value = (uint32_t)strtoul(digits, NULL, 16);
    return at + strlen(digits);
}

/* "1018sub1" @return DG_CO_KEY(), or 0 */
static uint32_t key_of(const char *section)
{
    uint32_t index = 0;
    uint32_t sub = 0;
    const char *rest = read_hex(section, 4, &index);
    if (rest != section + 4) {
        return 0;
    }
    if (*rest == '\0') {
        return DG_CO_KEY(index, 0);
    }
    if (strncasecmp(rest, "sub", 3) != 0) {
        return 0;
    }
    const char *end = read_hex(rest + 3, 2, &sub);
    return end > rest + 3 && *end == '\0' ? DG_CO_KEY(index, sub) : 0;
}

/* ---------------------------------------------------------------- names */

/* A line of the text without its end. */
static void take_parameter_name(struct explaining *self, const char *line, size_t n, uint32_t *key)
{
    static const char word[] = "ParameterName";
    char section[16];
    if (n > 1 && line[0] == '[') {
        const char *end = memchr(line, ']', n);
        const size_t length = end == NULL ? 0 : (size_t)(end - line) - 1u;
        (void)snprintf(section, sizeof section, "%.*s", (int)(length < sizeof section ? length : 0),
                       line + 1);
        *key = key_of(section);
    } else if (*key != 0 && n > sizeof word && strncasecmp(line, word, sizeof word - 1) == 0) {
        const char *at = memchr(line, '=', n);
        if (at != NULL) {
            const int most = (int)(line + n - at) - 1;
            self->names[self->name_count++] =
                (struct name){*key, at + 1, most < NAME_MAX_TOLD ? most : NAME_MAX_TOLD};
            *key = 0;
        }
    }
}

static int compare_names(const void *a, const void *b)
{
    const uint32_t first = ((const struct name *)a)->key;
    const uint32_t second = ((const struct name *)b)->key;
    return (first > second) - (first < second);
}

static void find_names(struct explaining *self)
{
    const char *at = self->file->text;
    const char *end = at + self->file->length;
    uint32_t key = 0;
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        const char *next = stop == NULL ? end : stop + 1;
        size_t n = (size_t)((stop == NULL ? end : stop) - at);
        n -= n > 0 && at[n - 1u] == '\r' ? 1u : 0u;
        take_parameter_name(self, at, n, &key);
        at = next;
    }
    qsort(self->names, self->name_count, sizeof *self->names, compare_names);
}

/* ---------------------------------------------------------------- lines */

static int compare_lines(const void *a, const void *b)
{
    const uint32_t first = ((const struct line *)a)->key;
    const uint32_t second = ((const struct line *)b)->key;
    return (first > second) - (first < second);
}

/* Behind the rows stands what is in the file and is no row. */
static void find_lines(struct explaining *self)
{
    const struct dg_co_file *file = &self->file->encoder.file;
    uint16_t count = 0;
    for (uint16_t i = 0; i < file->device.dictionary.count; i++) {
        const uint32_t key = file->device.dictionary.rows[i].key & 0xFFFFFF00u;
        if (count == 0 || self->lines[count - 1u].key != key) { /* 64 bits may have two rows */
            self->lines[count++] = (struct line){.key = key, .role = roles[dg_co_role_of(file, i)]};
        }
    }
    self->line_count = count;
    for (size_t i = 0; i < self->file->note_count; i++) {
        const struct dg_eds_note *note = &self->file->notes[i];
        const struct line wanted = {key_of(note->section), "refused", note->what};
        struct line *row = bsearch(&wanted, self->lines, count, sizeof *self->lines, compare_lines);
        if (row != NULL && note->lacks) {
            row->remark = note->what;
        } else if (row == NULL && note->lacks && wanted.key != 0) {
            self->lines[self->line_count++] = wanted;
        }
    }
    qsort(self->lines, self->line_count, sizeof *self->lines, compare_lines);
}

/* What a foreign file has is no command for a terminal. */
static void print_name(const struct name *name)
{
    int n = name->n;
    while (n > 0 && name->at[n - 1] == ' ') {
        n--;
    }
    for (int i = 0; i < n; i++) {
        const unsigned char c = (unsigned char)name->at[i];
        (void)putchar(c < ' ' || c == 0x7F ? '?' : c);
    }
}

static void print_named_line(const struct explaining *self, const struct line *line)
{
    const struct name wanted = {.key = line->key};
    const struct name *name =
        bsearch(&wanted, self->names, self->name_count, sizeof *self->names, compare_names);
    char sub[8] = "";
    if ((line->key & 0xFF00u) != 0) {
        (void)snprintf(sub, sizeof sub, ":%u", line->key >> 8 & 0xFFu);
    }
    const bool bare = name == NULL && line->remark == NULL;
    (void)printf("%04Xh%-5s%-*s", line->key >> 16, sub, bare ? 0 : ROLE_WIDTH, line->role);
    if (name != NULL) {
        print_name(name);
    }
    (void)printf("%s%s\n", line->remark == NULL || name == NULL ? "" : "; ",
                 line->remark == NULL ? "" : line->remark);
}

int eds_explain(const char *path)
{
    struct lx_error error;
    struct explaining self = {.file = eds_file_open(path, &error)};
    if (self.file == NULL) {
        return complain(&error, EXIT_OTHER);
    }
    /* A name takes a line with its key, an '=', and its end. */
    self.names = calloc(self.file->length / sizeof "ParameterName" + 1u, sizeof *self.names);
    self.lines =
        calloc(self.file->encoder.file.device.dictionary.count + self.file->note_count + 1u,
               sizeof *self.lines);
    const bool made = self.names != NULL && self.lines != NULL;
    if (made) {
        find_names(&self);
        find_lines(&self);
        for (size_t i = 0; i < self.line_count; i++) {
            print_named_line(&self, &self.lines[i]);
        }
    } else {
        lx_complain("%s: no memory for its contents", self.file->path);
    }
    free(self.names);
    free(self.lines);
    eds_file_close(self.file);
    return made ? EXIT_OK : EXIT_OTHER;
}
