/* SPDX-License-Identifier: MIT */
/* Motions of files; those in words are the library's to read. */
#define _GNU_SOURCE
#include "motion_words.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "csv.h"
#include "drehgeber/hal.h"
#include "file.h"

struct lx_shaft_file {
    FILE *file;
    struct lx_csv *lines;
};

struct lx_shaft_file *lx_shaft_file_open(const char *text, const struct lx_folder *folder,
                                         struct lx_error *error)
{
    struct lx_shaft_file *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory for its lines", text);
        return NULL;
    }
    self->file = lx_file_read(folder, text, error);
    if (self->file != NULL) {
        self->lines = lx_csv_open(self->file, text, &lx_csv_motion,
                                  folder == NULL ? SIZE_MAX : LX_CSV_CLIENT_MAX);
    }
    if (self->file != NULL && self->lines == NULL) {
        (void)lx_fail(error, "%s: no memory for its lines", text);
    }
    if (self->lines == NULL) {
        lx_shaft_file_close(self);
        return NULL;
    }
    return self;
}

int lx_shaft_file_read(struct lx_shaft_file *self, struct lx_shaft *to, struct lx_error *error)
{
    const int result = lx_csv_read_on(self->lines, LX_CSV_SLICE, error);
    if (result != 0) {
        return result < 0 ? LX_SHAFT_FILE : result;
    }
    const struct lx_csv_points recording = lx_csv_take(self->lines);
    *to = (struct lx_shaft){
        .motion = {.kind = DG_MOTION_REPLAY,
                   .points = recording.points,
                   .point_count = recording.count},
        .points = recording.points,
    };
    return 0;
}

void lx_shaft_file_close(struct lx_shaft_file *self)
{
    if (self == NULL) {
        return;
    }
    lx_csv_close(self->lines);
    if (self->file != NULL) {
        (void)fclose(self->file);
    }
    free(self);
}

static int parse_file(struct lx_shaft *self, const char *name, const struct lx_folder *folder,
                      struct lx_error *error)
{
    struct lx_shaft_file *file = lx_shaft_file_open(name, folder, error);
    int result = file == NULL ? -1 : 1;
    while (result > 0) {
        result = lx_shaft_file_read(file, self, error);
    }
    lx_shaft_file_close(file);
    return result;
}

int lx_shaft_parse(struct lx_shaft *self, const char *text, const struct lx_folder *folder,
                   struct lx_error *error)
{
    *self = (struct lx_shaft){.motion = {.kind = DG_MOTION_STANDSTILL}};
    if (dg_motion_is_file(text)) {
        return parse_file(self, text, folder, error) == 0 ? 0 : LX_SHAFT_FILE;
    }
    struct dg_plan_error wrong;
    if (dg_motion_read(&self->motion, text, &wrong) != DG_OK) {
        (void)lx_error_take(error, &wrong);
        return LX_SHAFT_WORDS;
    }
    return 0;
}

void lx_shaft_free(struct lx_shaft *self)
{
    free(self->points);
    self->points = NULL;
}
