/* SPDX-License-Identifier: MIT */
/* Courses that the plan has, and those that clients ask for. */
#define _GNU_SOURCE
#include <stdlib.h>

#include "courses.h"
#include "plan.h"
#include "rig_parts.h"

static struct lx_courses_setup setup_of(const struct lx_rig *self, struct dg_encoder *encoder)
{
    return (struct lx_courses_setup){
        .rig = self->control,
        .encoder = encoder,
        .folder = self->folder,
    };
}

/* Few encoders have any. */
static struct lx_courses *courses_of(struct lx_rig *self, size_t index, struct lx_error *error)
{
    struct lx_courses **at = &self->courses[index];
    if (*at == NULL) {
        *at = lx_courses_new();
    }
    if (*at == NULL) {
        (void)lx_fail(error, "no memory for a course");
    }
    return *at;
}

/* --- of the plan --- */

/* The setting is known to be sound, but for its file. */
struct dg_rig_course *lx_rig_find_course(void *ctx, size_t index,
                                         const struct dg_plan_setting *setting,
                                         struct lx_error *error)
{
    struct lx_rig *self = ctx;
    const struct dg_plan *plan = self->setup.plan;
    const struct dg_key *key = dg_keys_find(&dg_world_keys, setting->key);
    struct lx_courses *courses = courses_of(self, index, error);
    char *path = lx_plan_path(plan, setting->value, setting->line, error);
    struct dg_rig_course *course = NULL;
    int failure = LX_COURSES_WORDS;
    if (courses != NULL && path != NULL) {
        course =
            lx_courses_read(courses, (size_t)(key - dg_world_keys.rows), path, &failure, error);
    }
    free(path);
    if (course == NULL) {
        self->result = failure == LX_COURSES_FILE ? LX_RIG_WORLD : LX_RIG_PLAN;
        (void)lx_plan_refuse_setting(plan, setting, error);
    }
    return course;
}

void lx_rig_close_courses(struct lx_rig *self)
{
    for (size_t i = 0; self->courses != NULL && i < self->setup.plan->encoder_count; i++) {
        if (self->courses[i] != NULL) {
            lx_courses_free(self->courses[i], self->engine.control->encoders[i]);
        }
    }
    free(self->courses);
}

/* --- of clients --- */

static int told(int result, const struct lx_error *error, char *detail)
{
    static const int codes[] = {
        [-LX_COURSES_WORDS] = DG_SCPI_ILLEGAL,
        [-LX_COURSES_FILE] = DG_SCPI_FILE_NAME,
        [-LX_COURSES_BUSY] = DG_SCPI_CONFLICT,
    };
    return result >= 0 ? (result == 0 ? 0 : DG_RIG_READS)
                       : lx_rig_refuse(codes[-result], error, detail);
}

int lx_rig_course(struct dg_rig *control, struct dg_encoder *encoder,
                  const struct dg_rig_course_wish *wish, dg_ns now, char *detail)
{
    struct lx_rig *self = lx_rig_of(control);
    const struct lx_courses_setup setup = setup_of(self, encoder);
    struct lx_error error;
    struct lx_courses *courses = courses_of(self, dg_engine_index(control, encoder), &error);
    return told(courses == NULL ? LX_COURSES_WORDS
                                : lx_courses_begin(courses, &setup, wish, now, &error),
                &error, detail);
}

int lx_rig_course_more(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now, bool gone,
                       char *detail)
{
    struct lx_rig *self = lx_rig_of(control);
    const struct lx_courses_setup setup = setup_of(self, encoder);
    struct lx_courses *courses = self->courses[dg_engine_index(control, encoder)];
    struct lx_error error;
    if (gone) {
        lx_courses_read_none(courses);
        return 0;
    }
    return told(lx_courses_read_on(courses, &setup, now, &error), &error, detail);
}

const char *lx_rig_course_text(struct dg_rig *control, const struct dg_encoder *encoder,
                               size_t quantity)
{
    const struct lx_rig *self = lx_rig_of(control);
    return lx_courses_text(self->courses[dg_engine_index(control, encoder)], quantity);
}

void lx_rig_count_courses(const struct dg_encoder *encoder, struct dg_scpi *to)
{
    bool first = true;
    dg_state_begin(to, "courses");
    for (size_t i = 0; i < dg_world_keys.count; i++) {
        if (dg_rig_course_of(encoder, i) != NULL) {
            dg_scpi_append(to, first ? "" : "/");
            dg_scpi_append(to, dg_world_keys.rows[i].name);
            first = false;
        }
    }
    dg_state_end(to, first);
}
