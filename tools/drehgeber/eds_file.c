/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "eds_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "complain.h"
#include "drehgeber/devices.h"
#include "file.h"
#include "run.h"

/* Bytes to begin with; a file whose objects need more is read again. */
#define MEMORY_MIN 65536u
/* "[6501] DefaultValue=VALUE" */
#define PLACE_MAX (sizeof(struct dg_eds_note) + 8u)
/* Longest note in words. */
#define NOTE_MAX 512u
/* How much of a list is told when an encoder starts. */
#define VALUES_TOLD 8u
#define LACKS_TOLD 3u

static const char stdin_word[] = "-";

bool eds_file_is(const char *word)
{
    return word != NULL && (strcmp(word, stdin_word) == 0 || dg_model_file_of(word) != NULL);
}

/* ---------------------------------------------------------------- reading */

static void keep_note(void *ctx, const struct dg_eds_note *note)
{
    struct eds_file *self = ctx;
    if (self->kept && self->note_count == self->note_room) {
        const size_t room = self->note_room == 0 ? 16u : 2u * self->note_room;
        struct dg_eds_note *notes = reallocarray(self->notes, room, sizeof *notes);
        if (notes != NULL) {
            self->notes = notes;
            self->note_room = room;
        }
    }
    if (self->note_count < self->note_room) {
        self->notes[self->note_count++] = *note;
    }
}

/* One byte more than is allowed tells that there is more. @return 0, or -1 with `error` */
static int read_stream(struct eds_file *self, FILE *stream, struct lx_error *error)
{
    self->text = malloc(DG_EDS_BYTES_MAX + 1u);
    self->length = self->text == NULL ? 0 : fread(self->text, 1, DG_EDS_BYTES_MAX + 1u, stream);
    return self->text == NULL || ferror(stream) != 0
               ? lx_fail(error, "%s: cannot read: %s", self->path, strerror(errno))
               : 0;
}

static int read_text(struct eds_file *self, const char *path, struct lx_error *error)
{
    if (strcmp(path, stdin_word) == 0) {
        return read_stream(self, stdin, error);
    }
    FILE *stream = lx_file_read(NULL, path, error);
    if (stream == NULL) {
        return -1;
    }
    const int result = read_stream(self, stream, error);
    (void)fclose(stream);
    return result;
}

/* ":12" behind the file's name, and "[6501] DefaultValue". */
static void place_note(const struct dg_eds_note *note, char line[16], char place[PLACE_MAX])
{
    struct dg_text text = dg_text_in(place, PLACE_MAX);
    line[0] = '\0';
    if (note->line != 0) {
        (void)snprintf(line, 16, ":%u", note->line);
    }
    dg_co_say_place(note, &text);
}

static int refuse_note(const struct eds_file *self, const struct dg_eds_note *wrong,
                       struct lx_error *error)
{
    char line[16];
    char place[PLACE_MAX];
    struct lx_words right = {""};
    place_note(wrong, line, place);
    lx_words_add(&right, "expected %s", wrong->right == NULL ? "another file" : wrong->right);
    return lx_refuse(error, right.text, "%s%s: %s%s%s", self->path, line, place,
                     place[0] == '\0' ? "" : ": ", wrong->what);
}

/* @return as dg_co_read(), or DG_ERR_SPACE also without memory: `self->memory` is NULL then */
static int read_with(struct eds_file *self, struct dg_eds_note *wrong)
{
    const struct dg_eds_setup setup = {.size = sizeof setup,
                                       .text = self->text,
                                       .n = self->length,
                                       .memory = self->memory,
                                       .memory_size = self->memory_size,
                                       .note = keep_note,
                                       .ctx = self};
    return self->memory == NULL ? DG_ERR_SPACE : dg_cia406_read(&self->encoder, &setup, wrong);
}

/* As much memory as is needed; what is noted is kept when it is enough. */
static int read_objects(struct eds_file *self, struct lx_error *error)
{
    struct dg_eds_note wrong;
    int result = DG_ERR_SPACE;
    for (self->memory_size = MEMORY_MIN; result == DG_ERR_SPACE; self->memory_size *= 2u) {
        free(self->memory);
        self->memory = malloc(self->memory_size);
        result = read_with(self, &wrong);
        if (self->memory == NULL) {
            return lx_fail(error, "%s: no memory for its contents", self->path);
        }
    }
    self->memory_size /= 2u;
    if (result == DG_OK) {
        self->kept = true;
        result = read_with(self, &wrong);
    }
    return result == DG_OK ? 0 : refuse_note(self, &wrong, error);
}

struct eds_file *eds_file_open(const char *path, struct lx_error *error)
{
    struct eds_file *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %s", path);
        return NULL;
    }
    self->path = strcmp(path, stdin_word) == 0 ? "stdin" : path;
    if (read_text(self, path, error) != 0 || read_objects(self, error) != 0) {
        eds_file_close(self);
        return NULL;
    }
    return self;
}

void eds_file_close(struct eds_file *self)
{
    if (self != NULL) {
        free(self->notes);
        free(self->text);
        free(self->memory);
        free(self);
    }
}

/* ---------------------------------------------------------------- telling */

/* "acme.eds:12: [2000] DefaultValue=No is no number ...; expected ..." */
static void say_note(const struct eds_file *self, const struct dg_eds_note *note, char to[NOTE_MAX])
{
    char line[16];
    char place[PLACE_MAX];
    place_note(note, line, place);
    (void)snprintf(to, NOTE_MAX, "%s%s:%s%s %s%s%s", self->path, line, place[0] == '\0' ? "" : " ",
                   place, note->what, note->right == NULL ? "" : "; expected ",
                   note->right == NULL ? "" : note->right);
}

/* A long list is counted. */
static void tell_values(const struct eds_file *self, const struct lx_say *say)
{
    const struct dg_co_dictionary *dictionary = &self->encoder.file.device.dictionary;
    struct lx_words list = {""};
    unsigned count = 0;
    uint32_t last = 0;
    for (uint16_t i = 0; i < dictionary->count; i++) {
        const uint32_t index = dictionary->rows[i].key >> 16;
        if (dg_co_role_of(&self->encoder.file, i) != DG_CO_STORES || index == last) {
            continue;
        }
        last = index;
        if (count++ < VALUES_TOLD) {
            lx_words_add(&list, " %04Xh", (unsigned)index);
        }
    }
    if (count > VALUES_TOLD) {
        lx_words_add(&list, " and %u more; 'drehgeber eds %s --explain' lists them",
                     count - VALUES_TOLD, self->path);
    }
    if (count > 0) {
        lx_note(say, "%s: values only:%s", self->path, list.text);
    }
}

void eds_file_tell(const struct eds_file *self, const struct lx_say *say)
{
    unsigned lacks = 0;
    tell_values(self, say);
    for (size_t i = 0; i < self->note_count; i++) {
        if (self->notes[i].lacks && lacks++ < LACKS_TOLD) {
            char text[NOTE_MAX];
            say_note(self, &self->notes[i], text);
            lx_note(say, "%s", text);
        }
    }
    if (lacks > LACKS_TOLD) {
        lx_note(say, "%s: %u more that its encoder does not do; 'drehgeber check %s' lists them",
                self->path, lacks - LACKS_TOLD, self->path);
    }
}

void eds_file_tell_plan(const struct dg_plan *plan, const struct lx_say *say)
{
    for (size_t i = 0; i < plan->model_file_count; i++) {
        const struct dg_plan_model_file *file = &plan->model_files[i];
        if (file->lacks > 0) {
            lx_note(say, "%s: %u %s that its encoders do not do; 'drehgeber check %s' lists them",
                    file->file, file->lacks, file->lacks == 1 ? "thing" : "things", file->file);
        }
    }
}

/* "1 value", "2 values" */
static const char *plural(unsigned count, const char *one, const char *many)
{
    return count == 1 ? one : many;
}

int eds_file_check(const char *path)
{
    struct lx_error error;
    struct eds_file *self = eds_file_open(path, &error);
    if (self == NULL) {
        return complain(&error, EXIT_OTHER);
    }
    for (size_t i = 0; i < self->note_count; i++) {
        char text[NOTE_MAX];
        say_note(self, &self->notes[i], text);
        (void)printf("%s\n", text);
    }
    const struct dg_co_file *file = &self->encoder.file;
    const unsigned notes = (unsigned)self->note_count;
    (void)printf(
        "%s: %s, %s: %u %s, %u %s, %u %s, %u %s\n", self->path, self->encoder.name,
        self->encoder.resolution, file->objects, plural(file->objects, "object", "objects"),
        file->bound, plural(file->bound, "sub-index behaves", "sub-indices behave"), file->plain,
        plural(file->plain, "is a value", "are values"), notes, plural(notes, "note", "notes"));
    eds_file_close(self);
    return EXIT_OK;
}
