/* SPDX-License-Identifier: MIT */
/*
 * What an encoder was before it is changed, and how it is changed, in a file: each note is on the
 * disk before the change is sent. An empty file, or none, says that nothing is left to put back.
 */
#ifndef DREHGEBER_TOOL_VERIFY_JOURNAL_H
#define DREHGEBER_TOOL_VERIFY_JOURNAL_H

#include <stdbool.h>
#include <stdio.h>

#include "error.h"
#include "rows.h"

/* Most notes of a row; what would be one more is not sent. */
#define VERIFY_NOTES_MAX 400u
#define VERIFY_NOTE_BYTES 140u

struct verify_note {
    bool before; /* what it was; otherwise what is sent */
    uint16_t id;
    size_t n;
    uint8_t bytes[VERIFY_NOTE_BYTES];
};

struct verify_journal {
    FILE *file;        /* NULL: closed */
    const char *model; /* set by the caller: whose notes these are */
    bool headed;       /* it is written */
    char path[4096];
    size_t count;
    struct verify_note notes[VERIFY_NOTES_MAX];
};

/* Open the journal at `path`, NULL: in the user's folder for states. `dirty`: what it has is
   wanted, and of this model; otherwise it must have nothing. One run at a time has it. 0, or -1 with `error`. */
int verify_journal_open(struct verify_journal *self, const char *path, bool dirty,
                        struct lx_error *error);

/* Note it; of what is longer than a note the beginning. @return false: there is no room */
bool verify_journal_add(struct verify_journal *self, bool before, const struct cf_unit *unit);

/* Wait until all notes are on the disk. @return false: they are not */
bool verify_journal_sync(struct verify_journal *self);

/* All has been put back. @return false: the file could not be emptied */
bool verify_journal_clear(struct verify_journal *self);

/* The note as something that goes over a wire. */
struct cf_unit verify_note_unit(const struct verify_note *note);

void verify_journal_close(struct verify_journal *self);

#endif
