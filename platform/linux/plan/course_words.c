/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "course_words.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "drehgeber/hal.h"
#include "key.h"

int lx_course_parse(const char *text, struct dg_course_words *to, struct lx_error *error)
{
    struct dg_plan_error wrong;
    return dg_course_read(text, to, &wrong) == DG_OK ? 0 : lx_error_take(error, &wrong);
}

/* --- files --- */

struct lx_course_file {
    struct lx_csv_kind kind; /* with the texts of */
    struct lx_words line;
    struct lx_words value;
    FILE *file;
    struct lx_csv *lines;
};

static void put(void *points, size_t index, dg_ns at, int64_t value)
{
    struct dg_course_point *to = points;
    to[index] = (struct dg_course_point){at, (int32_t)value};
}

static void describe(struct lx_course_file *self, const struct dg_key *key)
{
    lx_words_add(&self->line, "time_s,%s", key->name);
    lx_words_add(&self->value, "the value is %s%s", key->type == DG_KEY_FLAG ? "" : "a number in ",
                 lx_key_range(key).text);
    self->kind = (struct lx_csv_kind){
        .line = self->line.text,
        .value = self->value.text,
        .places = key->places,
        .min = key->min,
        .max = key->max,
        .steps = true,
        .size = sizeof(struct dg_course_point),
        .put = put,
    };
}

struct lx_course_file *lx_course_file_open(const char *path, size_t quantity,
                                           const struct lx_folder *folder, struct lx_error *error)
{
    struct lx_course_file *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory for its lines", path);
        return NULL;
    }
    describe(self, &dg_world_keys.rows[quantity]);
    self->file = lx_file_read(folder, path, error);
    if (self->file != NULL) {
        self->lines = lx_csv_open(self->file, path, &self->kind,
                                  folder == NULL ? SIZE_MAX : LX_CSV_CLIENT_MAX);
    }
    if (self->file != NULL && self->lines == NULL) {
        (void)lx_fail(error, "%s: no memory for its lines", path);
    }
    if (self->lines == NULL) {
        lx_course_file_close(self);
        return NULL;
    }
    return self;
}

int lx_course_file_read(struct lx_course_file *self, struct lx_csv_points *to,
                        struct lx_error *error)
{
    const int result = lx_csv_read_on(self->lines, LX_CSV_SLICE, error);
    if (result == 0) {
        *to = lx_csv_take(self->lines);
    }
    return result;
}

void lx_course_file_close(struct lx_course_file *self)
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
