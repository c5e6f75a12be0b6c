/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "verify_journal.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define FOLDER "drehgeber"
#define NAME "verify.journal"
/* The first line: of which model the notes are. */
#define HEAD "of "

/* $XDG_STATE_HOME, or what it usually is. */
static int find_path(char *to, size_t size, struct lx_error *error)
{
    const char *state = getenv("XDG_STATE_HOME");
    const char *home = getenv("HOME");
    char folder[3800];
    if (state != NULL && state[0] == '/') {
        (void)snprintf(folder, sizeof folder, "%s", state);
    } else if (home != NULL && home[0] == '/') {
        (void)snprintf(folder, sizeof folder, "%s/.local", home);
        (void)mkdir(folder, 0700);
        (void)snprintf(folder, sizeof folder, "%s/.local/state", home);
    } else {
        return lx_refuse(error, "expected --journal=FILE", "no folder for the journal");
    }
    (void)mkdir(folder, 0700);
    (void)snprintf(to, size, "%s/" FOLDER, folder);
    (void)mkdir(to, 0700);
    (void)snprintf(to, size, "%s/" FOLDER "/" NAME, folder);
    return 0;
}

/* A new file is on the disk when its folder is, too. */
static bool sync_folder(const char *path)
{
    char copy[sizeof((struct verify_journal *)NULL)->path];
    (void)snprintf(copy, sizeof copy, "%s", path);
    const int fd = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool synced = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0) {
        (void)close(fd);
    }
    return synced;
}

/* "b 000 42 00 27 25 51": a note. @return whether it is a whole one */
static bool parse_note(char *line, struct verify_note *to)
{
    char *rest = NULL;
    char *word = strtok_r(line, " \n", &rest);
    *to = (struct verify_note){.before = word != NULL && strcmp(word, "b") == 0};
    if (word == NULL || (!to->before && strcmp(word, "s") != 0)) {
        return false;
    }
    word = strtok_r(NULL, " \n", &rest);
    to->id = word == NULL ? 0 : (uint16_t)strtoul(word, NULL, 16);
    while ((word = strtok_r(NULL, " \n", &rest)) != NULL && strcmp(word, ".") != 0) {
        if (to->n == sizeof to->bytes) {
            return false;
        }
        to->bytes[to->n++] = (uint8_t)strtoul(word, NULL, 16);
    }
    return word != NULL; /* a torn line has no dot: what it says was not sent */
}

/* @return whether all of it is about this model */
static bool load_journal(struct verify_journal *self)
{
    char line[3u * VERIFY_NOTE_BYTES + 32u];
    bool same = true;
    while (self->count < VERIFY_NOTES_MAX && fgets(line, sizeof line, self->file) != NULL) {
        if (strncmp(line, HEAD, sizeof HEAD - 1u) == 0) {
            line[strcspn(line, "\n")] = '\0';
            same = strcmp(line + sizeof HEAD - 1u, self->model) == 0;
        } else {
            self->count += parse_note(line, &self->notes[self->count]) ? 1u : 0u;
        }
    }
    return same || self->count == 0;
}

/* Take what is in the file; of two runs only one may have it. */
static int take_journal(struct verify_journal *self, bool dirty, struct lx_error *error)
{
    if (flock(fileno(self->file), LOCK_EX | LOCK_NB) != 0) {
        return lx_refuse(error, "expected another --journal for another encoder",
                         "%s: another run uses it", self->path);
    }
    rewind(self->file);
    const bool same = load_journal(self);
    if (!dirty && self->count > 0) {
        return lx_refuse(error, "expected --restore, which puts back the old values",
                         "%s: an earlier run has left an encoder changed", self->path);
    }
    return same ? 0
                : lx_refuse(error, "expected the model of the interrupted run", "%s: not of a %s",
                            self->path, self->model);
}

int verify_journal_open(struct verify_journal *self, const char *path, bool dirty,
                        struct lx_error *error)
{
    self->count = 0;
    self->file = NULL;
    self->headed = false;
    if (path != NULL) {
        (void)snprintf(self->path, sizeof self->path, "%s", path);
    } else if (find_path(self->path, sizeof self->path, error) != 0) {
        return -1;
    }
    self->file = fopen(self->path, "a+e"); /* each note behind the last one, also behind none */
    if (self->file == NULL) {
        return lx_fail(error, "%s: %s", self->path, strerror(errno));
    }
    return take_journal(self, dirty, error);
}

bool verify_journal_sync(struct verify_journal *self)
{
    return fflush(self->file) == 0 && ferror(self->file) == 0 && fsync(fileno(self->file)) == 0 &&
           sync_folder(self->path);
}

bool verify_journal_add(struct verify_journal *self, bool before, const struct cf_unit *unit)
{
    const size_t n = unit->n < VERIFY_NOTE_BYTES ? unit->n : VERIFY_NOTE_BYTES;
    if (self->count == VERIFY_NOTES_MAX) {
        return false;
    }
    struct verify_note *note = &self->notes[self->count];
    *note = (struct verify_note){.before = before, .id = unit->id, .n = n};
    memcpy(note->bytes, unit->bytes, n);
    if (!self->headed) {
        (void)fprintf(self->file, HEAD "%s\n", self->model);
        self->headed = true;
    }
    (void)fprintf(self->file, "%c %03X", before ? 'b' : 's', unit->id);
    for (size_t i = 0; i < n; i++) {
        (void)fprintf(self->file, " %02X", unit->bytes[i]);
    }
    (void)fputs(" .\n", self->file);
    self->count++;
    return ferror(self->file) == 0;
}

bool verify_journal_clear(struct verify_journal *self)
{
    self->count = 0;
    self->headed = false;
    return ftruncate(fileno(self->file), 0) == 0 && verify_journal_sync(self);
}

struct cf_unit verify_note_unit(const struct verify_note *note)
{
    return (struct cf_unit){.id = note->id, .bytes = note->bytes, .n = note->n};
}

void verify_journal_close(struct verify_journal *self)
{
    if (self->file != NULL) {
        (void)fclose(self->file);
    }
    self->file = NULL;
}
