/* SPDX-License-Identifier: MIT */
/* Encoders from EDS and DCF files: run FILE.eds, check FILE.eds. */
#ifndef DREHGEBER_TOOL_EDS_FILE_H
#define DREHGEBER_TOOL_EDS_FILE_H

#include <stdbool.h>

#include "drehgeber/cia406.h"
#include "error.h"

/* A file that was read. */
struct eds_file {
    struct dg_cia406_file encoder;
    const char *path;
    bool told; /* notes are printed as they come */
    unsigned note_count;
    char *text; /* owned, likewise the next */
    void *memory;
    size_t memory_size;
};

/* Whether a word of the command line is one: NAME.eds or NAME.dcf. */
bool eds_file_is(const char *word);

/* Read a file; `told`: notes go to stdout. @return NULL with `error` */
struct eds_file *eds_file_open(const char *path, bool told, struct lx_error *error);
void eds_file_close(struct eds_file *self);

/* `drehgeber check FILE.eds`: all notes, and a summary. @return how the program ends */
int eds_file_check(const char *path);

#endif
