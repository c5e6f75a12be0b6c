/* SPDX-License-Identifier: MIT */
/*
 * The reader asks for more memory by failing; then all is read again, from the same texts but for
 * what is included.
 */
#define _GNU_SOURCE
#include "plan.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/hal.h"
#include "file.h"
#include "wire.h"

/* Bytes to begin with, and behind each byte of a file: what names and lists are apart from their
   texts. Ranges need more. */
#define MEMORY_MIN 65536u
#define MEMORY_EACH 16u
/* Of a command line, which has at most a bus full of nodes. */
#define MEMORY_OF_OPTIONS 262144u
/* Behind a plan: control addresses with tokens, which a command line adds. */
#define MEMORY_SPARE 20480u
#define BLOCK 4096u
/* A rig of 100 000 encoders has a quarter of it; /dev/zero has no end. */
#define FILE_MAX ((size_t)32 << 20)

/* --- files --- */

/* A file's bytes; the list of them keeps them as long as a plan is being read. */
struct text {
    struct text *next;
    char *bytes;
    size_t n;
};

/* Of more than `most` bytes the rest is left. @return 0 or an errno */
static int read_stream(struct text *self, FILE *stream, size_t most)
{
    size_t room = 0;
    size_t n = 1;
    while (n > 0 && self->n <= most) {
        if (self->n == room) {
            room = room == 0 ? BLOCK : 2u * room;
            char *bytes = realloc(self->bytes, room);
            if (bytes == NULL) {
                return ENOMEM;
            }
            self->bytes = bytes;
        }
        n = fread(self->bytes + self->n, 1, room - self->n, stream);
        self->n += n;
    }
    return ferror(stream) != 0 ? errno : 0;
}

static void free_texts(struct text *list)
{
    while (list != NULL) {
        struct text *next = list->next;
        free(list->bytes);
        free(list);
        list = next;
    }
}

/* --- included files --- */

struct including {
    const char *file;        /* the first one */
    struct lx_folder folder; /* which it lies in, once another one is included */
    struct text *texts;
    const struct lx_plan_shelf *shelf; /* NULL: there are no other models */
    struct lx_error error;
};

static size_t prefix_of(const char *file)
{
    const char *slash = strrchr(file, '/');
    return slash == NULL ? 0 : (size_t)(slash + 1 - file);
}

static int open_folder(struct including *self)
{
    const size_t n = prefix_of(self->file);
    if (self->folder.fd >= 0) {
        return 0;
    }
    char *path = n == 0 ? strdup(".") : strndup(self->file, n);
    const int result = path == NULL ? lx_fail(&self->error, "no memory")
                                    : lx_folder_open(&self->folder, path, &self->error);
    free(path);
    return result;
}

/* @return NULL with self->error */
static FILE *open_included(struct including *self, const char *path)
{
    return open_folder(self) == 0
               ? lx_file_read(&self->folder, path + prefix_of(self->file), &self->error)
               : NULL;
}

static void keep_text(const struct including *self, const char *path,
                      const struct dg_plan_text *text)
{
    if (self->shelf != NULL && self->shelf->keep != NULL) {
        self->shelf->keep(self->shelf->ctx, path + prefix_of(self->file), text);
    }
}

/* Below the folder of the first file, whatever links there are. */
static const char *include_file(void *ctx, const char *path, struct dg_plan_text *to)
{
    struct including *self = ctx;
    struct text *text = calloc(1, sizeof *text);
    FILE *stream = text == NULL ? NULL : open_included(self, path);
    int reason = text == NULL ? ENOMEM : 0;
    if (stream != NULL) {
        reason = read_stream(text, stream, DG_PLAN_INCLUDED_MAX);
        (void)fclose(stream);
    }
    if (text != NULL) {
        text->next = self->texts;
        self->texts = text;
        *to = (struct dg_plan_text){text->bytes, text->n};
    }
    if (reason != 0) {
        (void)lx_fail(&self->error, "cannot read: %s", strerror(reason));
    }
    if (reason != 0 || stream == NULL) {
        return self->error.what;
    }
    keep_text(self, path, to);
    return NULL;
}

static const struct dg_device *find_on_shelf(void *ctx, const char *name)
{
    const struct including *self = ctx;
    return self->shelf->find_model(self->shelf->ctx, name);
}

/* --- the plan --- */

int lx_plan_make(struct dg_plan *self, struct lx_error *error)
{
    void *memory = malloc(MEMORY_OF_OPTIONS);
    dg_plan_begin(self, memory, memory == NULL ? 0 : MEMORY_OF_OPTIONS);
    return memory == NULL ? lx_fail(error, "no memory for a plan") : 0;
}

static int read_plan(struct dg_plan *self, struct dg_plan_setup *setup, struct lx_error *error)
{
    struct dg_plan_error wrong;
    int result = DG_ERR_SPACE;
    size_t size = MEMORY_MIN + MEMORY_EACH * setup->text.n;
    while (result == DG_ERR_SPACE) {
        free(setup->memory);
        setup->memory = malloc(size);
        setup->memory_size = size;
        if (setup->memory == NULL) {
            return lx_fail(error, "%s: no memory for its contents", setup->file);
        }
        result = dg_plan_read(self, setup, &wrong);
        if (result == 0 && (size_t)(self->end - self->at) < MEMORY_SPARE) {
            result = DG_ERR_SPACE;
        }
        size *= 2u;
    }
    if (result != 0) {
        free(setup->memory);
        return lx_error_take(error, &wrong);
    }
    return 0;
}

static int read_plan_text(struct dg_plan *self, const char *file, const struct text *text,
                          const struct lx_plan_shelf *shelf, struct lx_error *error)
{
    struct including including = {.file = file, .folder = LX_FOLDER_NONE, .shelf = shelf};
    struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = file,
        .text = {text->bytes, text->n},
        .include = include_file,
        .ctx = &including,
        .find_model = shelf == NULL ? NULL : find_on_shelf,
    };
    keep_text(&including, file, &setup.text);
    const int result = read_plan(self, &setup, error);
    lx_folder_close(&including.folder);
    free_texts(including.texts);
    return result;
}

int lx_plan_read(struct dg_plan *self, const char *file, struct lx_error *error)
{
    return lx_plan_read_with(self, file, NULL, error);
}

int lx_plan_read_with(struct dg_plan *self, const char *file, const struct lx_plan_shelf *shelf,
                      struct lx_error *error)
{
    struct text text = {.n = 0};
    FILE *stream = fopen(file, "re");
    *self = (struct dg_plan){.file = NULL};
    if (stream == NULL) {
        return lx_fail(error, "%s: cannot open: %s", file, strerror(errno));
    }
    int reason = read_stream(&text, stream, FILE_MAX);
    (void)fclose(stream);
    reason = reason == 0 && text.n > FILE_MAX ? EFBIG : reason;
    const int result = reason == 0 ? read_plan_text(self, file, &text, shelf, error)
                                   : lx_fail(error, "%s: cannot read: %s", file, strerror(reason));
    free(text.bytes);
    return result;
}

void lx_plan_free(struct dg_plan *self)
{
    free(self->memory);
    *self = (struct dg_plan){.file = NULL};
}

/* --- settings of a command line --- */

/* Key and value lie behind each other. */
static char *split_assignment(const char *assignment)
{
    char *text = strdup(assignment);
    if (text != NULL) {
        text[strcspn(text, "=")] = '\0';
    }
    return text;
}

int lx_plan_add_assignment(struct dg_plan_settings *self, const char *assignment, dg_plan_line line,
                           struct lx_error *error)
{
    const size_t n = strcspn(assignment, "=");
    if (n == 0 || assignment[n] == '\0') {
        (void)lx_refuse(error, "expected KEY=VALUE", "%s", "");
        return lx_about(error, LX_ABOUT_SETTING, assignment, NULL);
    }
    struct dg_plan_setting *list = reallocarray(self->list, self->count + 1u, sizeof *list);
    if (list == NULL) {
        return lx_fail(error, "no memory for %.*s", (int)n, assignment);
    }
    self->list = list;
    char *text = split_assignment(assignment);
    if (text == NULL) {
        return lx_fail(error, "no memory for %.*s", (int)n, assignment);
    }
    self->list[self->count++] = (struct dg_plan_setting){text, text + n + 1, line};
    return 0;
}

void lx_plan_free_settings(struct dg_plan_settings *self)
{
    for (size_t i = 0; i < self->count; i++) {
        free((char *)self->list[i].key);
    }
    free(self->list);
    *self = (struct dg_plan_settings){.list = NULL};
}

/* --- where things stand --- */

char *lx_plan_path(const struct dg_plan *self, const char *path, dg_plan_line line,
                   struct lx_error *error)
{
    const struct dg_plan_place place = dg_plan_place(self, line);
    const int folder = path[0] == '/' ? 0 : (int)place.folder;
    char *to = NULL;
    if (asprintf(&to, "%.*s%s", folder, folder == 0 ? "" : place.file, path) < 0) {
        (void)lx_fail(error, "no memory for %s", path);
        return NULL;
    }
    return to;
}

int lx_plan_stands(const struct dg_plan *self, dg_plan_line line, struct lx_error *error)
{
    const struct dg_plan_place place = dg_plan_place(self, line);
    if (error->where.line == 0 && place.file != self->file) {
        struct dg_text files = dg_text_in(error->where.included, sizeof error->where.included);
        dg_plan_say_files(self, line, &files);
    }
    return lx_stands(error, self->file, place.line);
}

int lx_plan_refuse_setting(const struct dg_plan *self, const struct dg_plan_setting *setting,
                           struct lx_error *error)
{
    (void)lx_about(error, LX_ABOUT_SETTING, setting->key, setting->value);
    return lx_plan_stands(self, setting->line, error);
}

int lx_plan_refuse_key(const struct dg_plan *self, const char *key, dg_plan_line line,
                       struct lx_error *error)
{
    (void)lx_about(error, LX_ABOUT_KEY, key, NULL);
    return lx_plan_stands(self, line, error);
}

int lx_plan_refuse_wire(const struct dg_plan *self, const struct dg_plan_wire *wire,
                        struct lx_error *error)
{
    (void)lx_about(error, LX_ABOUT_WIRE, wire->kind->name, wire->where);
    return lx_plan_stands(self, wire->where_line != 0 ? wire->where_line : wire->line, error);
}
