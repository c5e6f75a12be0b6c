/* SPDX-License-Identifier: MIT */
/*
 * inih takes lines apart into keys and values. It tells neither where they stand nor of sections
 * without keys, and takes an indented line for more of the one before; so the lines are handed to
 * it one by one, and sections are taken here.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <ini.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plan_section.h"

#define BLANKS " \t\r\n\v\f"
/* The start of a line, for a message. */
#define QUOTED 40

/* Where the reader is. */
struct reader {
    struct lx_plan *plan;
    struct lx_error *error;
    FILE *file;
    struct lx_plan_section section; /* the one that is being read */
    lx_line_number line;
    bool failed; /* `error` says how; the rest is not read */
    bool owed;   /* inih has a line that should give a key */
    char quoted[QUOTED + 1];
};

/* --- sections --- */

static void forget_section(struct reader *self)
{
    lx_plan_free_settings(&self->section.words);
    self->section = (struct lx_plan_section){.kind = NULL};
}

static int end_section(struct reader *self)
{
    const int result = self->section.kind == NULL
                           ? 0
                           : lx_plan_section_take(self->plan, &self->section, self->error);
    forget_section(self);
    return result;
}

/* The next word of a section's line; "" behind the last. */
static const char *next_word(char *text, char **rest)
{
    const char *found = strtok_r(text, BLANKS, rest);
    return found == NULL ? "" : found;
}

/* The section's own brackets are what the error is about. */
static int name_wrong(struct reader *self, const char *kind, const char *name, const char *more)
{
    struct lx_words section = {""};
    lx_words_add(&section, "[%s%s%s%s]", kind, *name == '\0' ? "" : " ", name, more);
    return lx_plan_refuse_key(self->plan, section.text, self->line, self->error);
}

/* What stands between the brackets: "KIND" or "KIND NAME". */
static int name_section(struct reader *self, char *text)
{
    char *rest = NULL;
    const char *kind = next_word(text, &rest);
    const char *name = next_word(NULL, &rest);
    const char *more = next_word(NULL, &rest);
    struct lx_plan_section *section = &self->section;
    section->line = self->line;
    section->kind = lx_plan_section_find(kind);
    if (section->kind == NULL) {
        return lx_plan_wrong_line(self->plan, self->line, self->error,
                                  LX_PLAN_SECTIONS " are right", "[%s]: no such section", kind);
    }
    if (!section->kind->named && *name != '\0') {
        struct lx_words right = {""};
        lx_words_add(&right, "[%s] is right", kind);
        return lx_plan_wrong_line(self->plan, self->line, self->error, right.text,
                                  "[%s %s]: has no name", kind, name);
    }
    if (section->kind->named && (*more != '\0' || !lx_plan_name_fits(name))) {
        struct lx_words right = {""};
        lx_words_add(&right, "a name of 1 to %u letters, digits, _ and - is right, as in [%s a1]",
                     LX_PLAN_NAME_MAX, kind);
        (void)lx_refuse(self->error, right.text, "%s", "");
        return name_wrong(self, kind, name, *more == '\0' ? "" : " ...");
    }
    (void)snprintf(section->name, sizeof section->name, "%s", name);
    return 0;
}

/* A line that begins with '['. Behind the ']' a comment may stand. */
static int begin_section(struct reader *self, char *text)
{
    char *end = strchr(text, ']');
    const char *behind = end == NULL ? "" : end + 1 + strspn(end + 1, BLANKS);
    if (end_section(self) != 0) {
        return -1;
    }
    if (end == NULL || strchr(";#", *behind) == NULL) {
        return lx_plan_wrong_line(self->plan, self->line, self->error,
                                  "[KIND NAME] on a line of its own is right", "'%s' is no section",
                                  self->quoted);
    }
    *end = '\0';
    return name_section(self, text + 1);
}

/* --- lines --- */

/* As it is quoted: without what ends it. */
static void quote(struct reader *self, const char *text)
{
    (void)snprintf(self->quoted, sizeof self->quoted, "%s", text);
    self->quoted[strcspn(self->quoted, "\r\n")] = '\0';
}

/* Blanks in front would make it more of the line before. A byte order mark opens many files. */
static void trim(struct reader *self, char *text)
{
    static const char mark[] = "\xEF\xBB\xBF";
    size_t n = self->line == 1 && strncmp(text, mark, strlen(mark)) == 0 ? strlen(mark) : 0;
    n += strspn(text + n, BLANKS);
    memmove(text, text + n, strlen(text + n) + 1);
    quote(self, text);
}

/* The line that inih has in hand. */
static int take_line(struct reader *self, char *text, int size)
{
    self->line++;
    if (strchr(text, '\n') == NULL && feof(self->file) == 0) {
        return lx_plan_wrong_line(self->plan, self->line, self->error,
                                  "a shorter line of text is right",
                                  "more than %d characters, or no text at all", size - 2);
    }
    trim(self, text);
    if (*text == '[') {
        const int result = begin_section(self, text);
        *text = '\0';
        return result;
    }
    self->owed = strchr(";#", *text) == NULL;
    return 0;
}

/* inih's reader, as fgets(). */
static char *next_line(char *to, int size, void *ctx)
{
    struct reader *self = ctx;
    if (!self->failed && self->owed) {
        (void)lx_plan_wrong_line(self->plan, self->line, self->error, "one of them is right",
                                 "'%s' is neither [SECTION] nor KEY = VALUE", self->quoted);
        self->failed = true;
    }
    if (self->failed || fgets(to, size, self->file) == NULL) {
        return NULL;
    }
    self->failed = take_line(self, to, size) != 0;
    return self->failed ? NULL : to;
}

static const struct lx_plan_setting *find_word(const struct reader *self, const char *key)
{
    const struct lx_plan_settings *words = &self->section.words;
    for (size_t i = 0; i < words->count; i++) {
        if (strcmp(words->list[i].key, key) == 0) {
            return &words->list[i];
        }
    }
    return NULL;
}

static int take_word(struct reader *self, const char *key, const char *value)
{
    const struct lx_plan_section_kind *kind = self->section.kind;
    const struct lx_plan_setting *before = find_word(self, key);
    const struct lx_plan_setting row = {.key = (char *)key, .line = self->line};
    if (*key == '\0') {
        return lx_plan_wrong_line(self->plan, self->line, self->error, "KEY = VALUE is right",
                                  "no key in front of '= %s'", value);
    }
    if (kind == NULL) {
        return lx_plan_wrong_word(self->plan, &row, self->error, LX_PLAN_SECTIONS " are right",
                                  "stands before the first section");
    }
    if (before != NULL && (kind->repeats == NULL || strcmp(kind->repeats, key) != 0)) {
        return lx_plan_wrong_word(self->plan, &row, self->error, "one of them is right",
                                  "stands in line %u already", before->line);
    }
    return lx_plan_add_setting(&self->section.words, key, value, self->line, self->error);
}

/* inih's handler. @return 0: the line is wrong */
static int on_word(void *ctx, const char *section, const char *key, const char *value)
{
    struct reader *self = ctx;
    (void)section;
    self->owed = false;
    self->failed = self->failed || take_word(self, key, value) != 0;
    return self->failed ? 0 : 1;
}

/* --- the whole file --- */

/* What only the end of the file tells. */
static int check_whole(const struct lx_plan *plan, struct lx_error *error)
{
    for (size_t i = 0; i < plan->wire_count; i++) {
        if (plan->wires[i].encoder_count == 0) {
            struct lx_words right = {""};
            lx_words_add(&right, "bus = %s in an [encoder NAME] is right, or no such bus",
                         plan->wires[i].name);
            return lx_plan_wrong_line(plan, plan->wires[i].line, error, right.text,
                                      "[bus %s]: without encoders", plan->wires[i].name);
        }
    }
    return plan->encoder_count > 0
               ? 0
               : lx_refuse(error, "[encoder NAME] with model = MODEL and wire = KIND is right",
                           "%s: without encoders", plan->file);
}

/* The file's name without its folder and its ending. */
static char *name_of(const char *file)
{
    const char *slash = strrchr(file, '/');
    const char *base = slash == NULL ? file : slash + 1;
    const char *dot = strrchr(base, '.');
    return strndup(base, dot == NULL || dot == base ? strlen(base) : (size_t)(dot - base));
}

static int read_lines(struct reader *self)
{
    (void)ini_parse_stream(next_line, self, on_word, self);
    if (!self->failed && ferror(self->file) != 0) {
        (void)lx_fail(self->error, "%s: cannot read: %s", self->plan->file, strerror(errno));
        self->failed = true;
    }
    if (!self->failed) {
        self->failed = end_section(self) != 0 || check_whole(self->plan, self->error) != 0;
    }
    forget_section(self);
    return self->failed ? -1 : 0;
}

static int read_file(struct lx_plan *plan, FILE *file, struct lx_error *error)
{
    struct reader self = {.plan = plan, .error = error, .file = file};
    if (read_lines(&self) != 0) {
        return -1;
    }
    if (plan->name == NULL) {
        plan->name = name_of(plan->file);
    }
    return plan->name == NULL ? lx_fail(error, "%s: no memory", plan->file) : 0;
}

int lx_plan_read(struct lx_plan *self, const char *file, struct lx_error *error)
{
    *self = (struct lx_plan){.file = file};
    FILE *stream = fopen(file, "re");
    int result = 0;
    if (stream == NULL) {
        result = lx_fail(error, "%s: cannot open: %s", file, strerror(errno));
    } else {
        result = read_file(self, stream, error);
        (void)fclose(stream);
    }
    if (result != 0) {
        lx_plan_free(self);
    }
    return result;
}
