/* SPDX-License-Identifier: MIT */
#include "course_words.h"

#include "drehgeber/hal.h"
#include "key.h"

int lx_course_parse(const char *text, struct dg_course_words *to, struct lx_error *error)
{
    struct dg_plan_error wrong;
    return dg_course_read(text, to, &wrong) == DG_OK ? 0 : lx_error_take(error, &wrong);
}

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
    lx_words_add(&kind.value, "the value is %s%s", key->type == DG_KEY_FLAG ? "" : "a number in ",
                 lx_key_range(key).text);
    return lx_csv_open(path, folder, &kind, error);
}
