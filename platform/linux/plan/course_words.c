/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "course_words.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "drehgeber/hal.h"
#include "key.h"

static const char ending[] = ".csv";

/* --- words --- */

/* Characters of the name at the beginning; 0: there is none. */
static size_t name_of(const char *text)
{
    const size_t n = strcspn(text, ",");
    const size_t end = strlen(ending);
    return n > end && strncasecmp(text + n - end, ending, end) == 0 ? n : 0;
}

bool lx_course_is(const char *text)
{
    return name_of(text) > 0;
}

static bool take_word(const char *word, size_t n, struct lx_course_words *to)
{
    static const char *const words[] = {"once", "loop", "linear", "step"};
    size_t i = 0;
    while (i < DG_COUNT(words) && (n != strlen(words[i]) || strncasecmp(word, words[i], n) != 0)) {
        i++;
    }
    to->loop = to->loop || i == 1;
    to->steps = to->steps || i == 3;
    return i < DG_COUNT(words);
}

int lx_course_parse(const char *text, struct lx_course_words *to, struct lx_error *error)
{
    *to = (struct lx_course_words){.name = name_of(text)};
    if (to->name == 0) {
        return lx_refuse(error, LX_COURSE_FORM " is right", "'%s' is no CSV file", text);
    }
    for (const char *at = text + to->name; at[0] == ','; at += strcspn(at, ",")) {
        at++;
        at += strspn(at, " ");
        const size_t n = strcspn(at, ",");
        if (!take_word(at, n, to)) {
            return lx_refuse(error, LX_COURSE_FORM " is right", "'%.*s' is none of the words",
                             (int)n, at);
        }
    }
    return 0;
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
