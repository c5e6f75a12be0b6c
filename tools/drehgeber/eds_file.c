/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "eds_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "complain.h"
#include "file.h"
#include "run.h"

/* Bytes to begin with; a file whose objects need more is read again. */
#define MEMORY_MIN 65536u
/* "[6501] DefaultValue=VALUE" */
#define PLACE_MAX (sizeof(struct dg_eds_note) + 8u)

bool eds_file_is(const char *word)
{
    static const char *const endings[] = {".eds", ".dcf"};
    const size_t n = word == NULL ? 0 : strlen(word);
    for (size_t i = 0; i < DG_COUNT(endings); i++) {
        if (n > strlen(endings[i]) && strcasecmp(word + n - strlen(endings[i]), endings[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* "acme.eds:12: [2000] DefaultValue=No: is no number ...; right is ..." */
static void print_note(void *ctx, const struct dg_eds_note *note)
{
    struct eds_file *self = ctx;
    self->note_count++;
    if (!self->told) {
        return;
    }
    (void)printf("%s:", self->path);
    if (note->line != 0) {
        (void)printf("%u:", note->line);
    }
    char place[PLACE_MAX];
    struct dg_text text = dg_text_in(place, sizeof place);
    dg_co_say_place(note, &text);
    (void)printf("%s%s %s%s%s\n", place[0] == '\0' ? "" : " ", place, note->what,
                 note->right == NULL ? "" : "; right is ", note->right == NULL ? "" : note->right);
}

/* One byte more than is allowed tells that there is more. @return bytes, or -1 with `error` */
static long read_text(struct eds_file *self, struct lx_error *error)
{
    FILE *stream = lx_file_read(NULL, self->path, error);
    if (stream == NULL) {
        return -1;
    }
    self->text = malloc(DG_EDS_BYTES_MAX + 1u);
    const size_t n = self->text == NULL ? 0 : fread(self->text, 1, DG_EDS_BYTES_MAX + 1u, stream);
    const bool failed = self->text == NULL || ferror(stream) != 0;
    const int reason = errno;
    (void)fclose(stream);
    return failed ? lx_fail(error, "%s: cannot read: %s", self->path, strerror(reason)) : (long)n;
}

static int refuse(const struct eds_file *self, const struct dg_eds_note *wrong,
                  struct lx_error *error)
{
    char line[16] = "";
    char place[PLACE_MAX];
    struct dg_text text = dg_text_in(place, sizeof place);
    dg_co_say_place(wrong, &text);
    if (wrong->line != 0) {
        (void)snprintf(line, sizeof line, ":%u", wrong->line);
    }
    return lx_refuse(error, wrong->right == NULL ? "another file" : wrong->right, "%s%s: %s%s%s",
                     self->path, line, place, place[0] == '\0' ? "" : ": ", wrong->what);
}

/* @return as dg_co_read(), or DG_ERR_SPACE also without memory: `self->memory` is NULL then */
static int read_with(struct eds_file *self, size_t n, struct dg_eds_note *wrong)
{
    const struct dg_eds_setup setup = {.size = sizeof setup,
                                       .text = self->text,
                                       .n = n,
                                       .memory = self->memory,
                                       .memory_size = self->memory_size,
                                       .note = print_note,
                                       .ctx = self};
    self->note_count = 0;
    return self->memory == NULL ? DG_ERR_SPACE : dg_cia406_read(&self->encoder, &setup, wrong);
}

/* As much memory as is needed; what is noted is told when it is enough. */
static int read_objects(struct eds_file *self, size_t n, bool told, struct lx_error *error)
{
    struct dg_eds_note wrong;
    int result = DG_ERR_SPACE;
    for (self->memory_size = MEMORY_MIN; result == DG_ERR_SPACE; self->memory_size *= 2u) {
        free(self->memory);
        self->memory = malloc(self->memory_size);
        result = read_with(self, n, &wrong);
        if (self->memory == NULL) {
            return lx_fail(error, "%s: no memory for what is in it", self->path);
        }
    }
    self->memory_size /= 2u;
    if (result == DG_OK) {
        self->told = told;
        result = read_with(self, n, &wrong);
    }
    return result == DG_OK ? 0 : refuse(self, &wrong, error);
}

struct eds_file *eds_file_open(const char *path, bool told, struct lx_error *error)
{
    struct eds_file *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %s", path);
        return NULL;
    }
    self->path = path;
    const long n = read_text(self, error);
    if (n < 0 || read_objects(self, (size_t)n, told, error) != 0) {
        eds_file_close(self);
        return NULL;
    }
    return self;
}

void eds_file_close(struct eds_file *self)
{
    if (self != NULL) {
        free(self->text);
        free(self->memory);
        free(self);
    }
}

int eds_file_check(const char *path)
{
    struct lx_error error;
    struct eds_file *self = eds_file_open(path, true, &error);
    if (self == NULL) {
        return complain(&error, EXIT_OTHER);
    }
    const struct dg_co_file *file = &self->encoder.file;
    (void)printf("%s: %s, %s: %u objects, %u sub-indices behave, %u are values, %u notes\n", path,
                 self->encoder.name, self->encoder.resolution, (unsigned)file->objects,
                 (unsigned)file->bound, (unsigned)file->plain, self->note_count);
    eds_file_close(self);
    return EXIT_OK;
}
