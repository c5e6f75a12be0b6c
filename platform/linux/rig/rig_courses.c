/* SPDX-License-Identifier: MIT */
/* Courses that the plan has, and those that clients ask for. */
#define _GNU_SOURCE
#include <stdlib.h>

#include "courses.h"
#include "plan.h"
#include "rig_parts.h"

static size_t index_of(const struct lx_rig *self, const struct dg_encoder *encoder)
{
    const struct lx_station *station = encoder->host;
    return (size_t)(station - self->stations);
}

static struct lx_courses_setup setup_of(struct lx_rig *self, struct dg_encoder *encoder)
{
    return (struct lx_courses_setup){
        .rig = &self->control,
        .encoder = encoder,
        .folder = self->folder,
    };
}

/* Few encoders have any. */
static struct lx_courses *courses_of(struct lx_rig *self, const struct dg_encoder *encoder,
                                     struct lx_error *error)
{
    struct lx_courses **at = &self->courses[index_of(self, encoder)];
    if (*at == NULL) {
        *at = lx_courses_new();
    }
    if (*at == NULL) {
        (void)lx_fail(error, "no memory for a course");
    }
    return *at;
}

/* --- of the plan --- */

static int begin(struct lx_rig *self, struct dg_encoder *encoder, size_t quantity, const char *path,
                 struct lx_error *error)
{
    const struct lx_courses_setup setup = setup_of(self, encoder);
    const struct dg_rig_course_wish wish = {.quantity = quantity, .path = path};
    struct lx_courses *courses = courses_of(self, encoder, error);
    int result = courses == NULL ? LX_COURSES_WORDS
                                 : lx_courses_begin(courses, &setup, &wish, self->begin, error);
    while (result > 0) {
        result = lx_courses_read_on(courses, &setup, self->begin, error);
    }
    return result;
}

/* The setting is known to be sound, but for its file. */
static enum lx_rig_result begin_setting(struct lx_rig *self, struct dg_encoder *encoder,
                                        const struct dg_plan_setting *setting,
                                        struct lx_error *error)
{
    const struct dg_key *key = dg_keys_find(&dg_world_keys, setting->key);
    if (key == NULL || !dg_course_is(setting->value)) {
        return LX_RIG_OK;
    }
    char *path = lx_plan_path(self->setup.plan, setting->value, setting->line, error);
    const int result =
        path == NULL ? -1 : begin(self, encoder, (size_t)(key - dg_world_keys.rows), path, error);
    free(path);
    if (result == 0) {
        return LX_RIG_OK;
    }
    (void)lx_plan_refuse_setting(self->setup.plan, setting, error);
    return result == LX_COURSES_FILE ? LX_RIG_WORLD : LX_RIG_PLAN;
}

enum lx_rig_result lx_rig_begin_courses(struct lx_rig *self, struct lx_error *error)
{
    enum lx_rig_result result = LX_RIG_OK;
    for (size_t i = 0; i < self->setup.plan->encoder_count; i++) {
        const struct dg_plan_settings *settings = &self->setup.plan->encoders[i].settings;
        for (size_t j = 0; result == LX_RIG_OK && j < settings->count; j++) {
            result = begin_setting(self, &self->stations[i].control, &settings->list[j], error);
        }
    }
    return result;
}

void lx_rig_close_courses(struct lx_rig *self)
{
    /* Without stations none has begun. */
    const bool begun = self->courses != NULL && self->stations != NULL;

    for (size_t i = 0; begun && i < self->setup.plan->encoder_count; i++) {
        lx_courses_free(self->courses[i], &self->stations[i].control);
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
    struct lx_rig *self = control->host;
    const struct lx_courses_setup setup = setup_of(self, encoder);
    struct lx_error error;
    struct lx_courses *courses = courses_of(self, encoder, &error);
    return told(courses == NULL ? LX_COURSES_WORDS
                                : lx_courses_begin(courses, &setup, wish, now, &error),
                &error, detail);
}

int lx_rig_course_more(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now, bool gone,
                       char *detail)
{
    struct lx_rig *self = control->host;
    const struct lx_courses_setup setup = setup_of(self, encoder);
    struct lx_courses *courses = self->courses[index_of(self, encoder)];
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
    const struct lx_rig *self = control->host;
    return lx_courses_text(self->courses[index_of(self, encoder)], quantity);
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
