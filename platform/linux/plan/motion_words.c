/* SPDX-License-Identifier: MIT */
/* Motions and courses of files; words are the library's to read. */
#include "motion_words.h"

#include <stdlib.h>

#include "drehgeber/hal.h"
#include "drehgeber/key.h"

int lx_shaft_read_on(struct lx_csv *file, struct lx_shaft *to, struct lx_error *error)
{
    const int result = lx_csv_read_on(file, LX_CSV_SLICE, error);
    if (result != 0) {
        return result < 0 ? LX_SHAFT_FILE : result;
    }
    const struct lx_csv_points recording = lx_csv_take(file);
    *to = (struct lx_shaft){
        .motion = {.kind = DG_MOTION_REPLAY,
                   .points = recording.points,
                   .point_count = recording.count},
        .points = recording.points,
    };
    return 0;
}

static int parse_file(struct lx_shaft *self, const char *name, const struct lx_folder *folder,
                      struct lx_error *error)
{
    struct lx_csv *file = lx_csv_open(name, folder, &lx_csv_motion, error);
    int result = file == NULL ? -1 : 1;
    while (result > 0) {
        result = lx_shaft_read_on(file, self, error);
    }
    lx_csv_close(file);
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

/* --- courses --- */

static void put_point(void *points, size_t index, dg_ns at, int64_t value)
{
    struct dg_course_point *to = points;
    to[index] = (struct dg_course_point){at, (int32_t)value};
}

struct lx_csv *lx_course_open(const char *path, size_t quantity, const struct lx_folder *folder,
                              struct lx_error *error)
{
    const struct dg_key *key = &dg_world_keys.rows[quantity];
    struct lx_csv_kind kind = {
        .column = key->name,
        .places = key->places,
        .min = key->min,
        .max = key->max,
        .steps = true,
        .size = sizeof(struct dg_course_point),
        .put = put_point,
    };
    struct dg_text value = dg_text_in(kind.value.text, sizeof kind.value.text);
    dg_text_add(&value, key->type == DG_KEY_FLAG ? "the value is " : "the value is a number in ");
    dg_key_say_range(key, &value);
    return lx_csv_open(path, folder, &kind, error);
}
