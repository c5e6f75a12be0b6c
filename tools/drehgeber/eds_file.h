/* SPDX-License-Identifier: MIT */
/* Encoders from EDS and DCF files: run FILE.eds, check FILE.eds, eds FILE.eds --explain. */
#ifndef DREHGEBER_TOOL_EDS_FILE_H
#define DREHGEBER_TOOL_EDS_FILE_H

#include <stdbool.h>

#include "drehgeber/cia406.h"
#include "drehgeber/rig.h"
#include "error.h"
#include "say.h"

/* A file that was read. */
struct eds_file {
    struct dg_cia406_file encoder;
    const char *path;          /* as it is told */
    struct dg_eds_note *notes; /* owned, likewise the next two */
    char *text;
    void *memory;
    size_t note_count;
    size_t note_room;
    size_t length; /* of the text */
    size_t memory_size;
    bool kept; /* notes are, from now on */
};

/* Whether a word of the command line is one: NAME.eds, NAME.dcf, or "-" for stdin. */
bool eds_file_is(const char *word);

/* Read a file. @return NULL with `error` */
struct eds_file *eds_file_open(const char *path, struct lx_error *error);
void eds_file_close(struct eds_file *self);

/* What whoever runs it should know, in a few notes: what only stores, and what the file promises
   and the encoder does not do. */
void eds_file_tell(const struct eds_file *self, const struct lx_say *say);
/* The same of the files of a rig, in a note for each. */
void eds_file_tell_plan(const struct dg_plan *plan, const struct lx_say *say);

/* `drehgeber check FILE.eds`: all notes, and a summary. @return how the program ends */
int eds_file_check(const char *path);

/* `drehgeber eds FILE.eds --explain`: a line for each sub-index. @return likewise */
int eds_explain(const char *path);

#endif
