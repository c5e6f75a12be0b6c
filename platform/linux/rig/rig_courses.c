/* SPDX-License-Identifier: MIT */
/*
 * Courses that the plan has, and those that clients ask for: their points, and files that are being
 * read for them. The core lets the world follow them (drehgeber/control.h).
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/quantity.h"
#include "plan.h"
#include "rig_parts.h"

/* What may be wrong. */
enum failure {
    WORDS = -1,     /* not a course */
    FROM_FILE = -2, /* the file cannot be read, or what is in it */
    BUSY = -3,      /* another file is being read for this encoder */
    NO_ROOM = -4,   /* more than [rig] memory says */
};

/* One that is followed. */
struct place {
    struct dg_rig_course course;
    struct dg_course_point *points; /* owned, as is the text */
    char *text;
    bool lent; /* a client has asked for it */
};

struct lx_courses {
    struct lx_rig *rig;
    struct dg_encoder *encoder;
    struct place places[DG_QUANTITY_COUNT];
    struct lx_csv *reading; /* NULL: none */
    struct place next;      /* what is being read for */
};

/* Few encoders have any. */
static struct lx_courses *courses_of(struct lx_rig *self, size_t index, struct lx_error *error)
{
    struct lx_courses **at = &self->courses[index];
    if (*at == NULL) {
        *at = lx_allocate(sizeof **at, "a course", error);
    }
    if (*at != NULL) {
        (*at)->rig = self;
        (*at)->encoder = self->engine.control->encoders[index];
    }
    return *at;
}

static void empty(struct place *place)
{
    free(place->points);
    free(place->text);
    *place = (struct place){.points = NULL};
}

static void read_none(struct lx_courses *self)
{
    lx_csv_close(self->reading);
    self->reading = NULL;
    empty(&self->next);
}

void lx_rig_close_courses(struct lx_rig *self)
{
    for (size_t i = 0; self->courses != NULL && i < self->setup.plan->encoder_count; i++) {
        struct lx_courses *courses = self->courses[i];
        if (courses != NULL) {
            read_none(courses);
            courses->encoder->courses = NULL;
            for (size_t n = 0; n < DG_QUANTITY_COUNT; n++) {
                empty(&courses->places[n]);
            }
            free(courses);
        }
    }
    free(self->courses);
}

/* --- what is asked for --- */

/* But for the points. "FILE.csv,LOOP,STEP" as a setting says it, or "points,LOOP". */
static int read_course_words(struct place *next, const struct dg_rig_course_wish *wish,
                             struct dg_course_words *words, struct lx_error *error)
{
    const bool state = dg_quantities[wish->quantity].unit == DG_UNIT_STATE;
    struct dg_course *course = &next->course.course;
    struct dg_plan_error wrong;
    *words = (struct dg_course_words){.name = strlen("points")};
    if (wish->path != NULL && dg_course_read(wish->path, words, &wrong) != DG_OK) {
        return lx_error_take(error, &wrong);
    }
    next->course.quantity = wish->quantity;
    course->loop = wish->loop || words->loop;
    course->steps = wish->steps || words->steps || state;
    if (asprintf(&next->text, "%.*s%s%s", (int)words->name,
                 wish->path == NULL ? "points" : wish->path, course->loop ? ",LOOP" : "",
                 course->steps && !state ? ",STEP" : "") < 0) {
        next->text = NULL;
        return lx_fail(error, "no memory for a course");
    }
    return 0;
}

/* @return 1: it is being read; enum failure with `error` */
static int open_file(struct lx_courses *self, const struct lx_folder *folder,
                     const struct dg_rig_course_wish *wish, size_t name, struct lx_error *error)
{
    char *path = strndup(wish->path, name);
    if (path == NULL) {
        (void)lx_fail(error, "no memory for a course");
        return WORDS;
    }
    self->reading = lx_course_open(path, wish->quantity, folder, error);
    free(path);
    return self->reading == NULL ? FROM_FILE : 1;
}

/* @return 0: all of it is there; else as open_file() */
static int read_slice(struct lx_courses *self, struct lx_error *error)
{
    const int result = lx_csv_read_on(self->reading, LX_CSV_SLICE, error);
    if (result == 0) {
        const struct lx_csv_points found = lx_csv_take(self->reading);
        self->next.points = found.points;
        self->next.course.course.count = found.count;
    }
    return result < 0 ? FROM_FILE : result;
}

/* --- of the plan --- */

/* All of the file at once. @return as read_slice() */
static int read_course_file(struct lx_courses *self, size_t quantity, const char *path,
                            struct lx_error *error)
{
    const struct dg_rig_course_wish wish = {.quantity = quantity, .path = path};
    struct dg_course_words words;
    int result = read_course_words(&self->next, &wish, &words, error) != 0
                     ? WORDS
                     : open_file(self, NULL, &wish, words.name, error);
    while (result > 0) {
        result = read_slice(self, error);
    }
    if (result == 0) {
        self->places[quantity] = self->next;
        self->places[quantity].course.course.points = self->next.points;
        self->next = (struct place){.points = NULL};
    }
    read_none(self);
    return result;
}

/* The setting is known to be sound, but for its file. */
struct dg_rig_course *lx_rig_find_course(void *ctx, size_t index,
                                         const struct dg_plan_setting *setting,
                                         struct lx_error *error)
{
    struct lx_rig *self = ctx;
    const struct dg_plan *plan = self->setup.plan;
    const struct dg_key *key = dg_keys_find(&dg_world_keys, setting->key);
    const size_t quantity = (size_t)(key - dg_world_keys.rows);
    struct lx_courses *courses = courses_of(self, index, error);
    char *path = lx_plan_path(plan, setting->value, setting->line, error);
    const int result =
        courses != NULL && path != NULL ? read_course_file(courses, quantity, path, error) : WORDS;
    free(path);
    if (result == 0) {
        return &courses->places[quantity].course;
    }
    self->result = result == FROM_FILE ? LX_RIG_WORLD : LX_RIG_PLAN;
    (void)lx_plan_refuse_setting(plan, setting, error);
    return NULL;
}

/* --- of clients --- */

/* Points of clients that are followed, but for those of `but`; others are given back. */
static uint64_t count_lent(const struct lx_rig *self, const struct place *but)
{
    uint64_t count = 0;
    for (size_t i = 0; i < self->setup.plan->encoder_count; i++) {
        struct lx_courses *courses = self->courses[i];
        for (size_t n = 0; courses != NULL && n < DG_QUANTITY_COUNT; n++) {
            struct place *place = &courses->places[n];
            const bool followed = dg_rig_course_of(courses->encoder, n) == &place->course;
            if (place->lent && !followed) {
                empty(place);
            }
            count += place->lent && place != but ? place->course.course.count : 0;
        }
    }
    return count;
}

static bool has_course_room(const struct lx_courses *self)
{
    const struct place *but = &self->places[self->next.course.quantity];
    const uint64_t most = self->rig->setup.plan->course_memory;
    return most == 0 || count_lent(self->rig, but) + self->next.course.course.count <=
                            most / DG_PLAN_POINT_BYTES;
}

/* `next` is complete; what cannot be is only found now, and leaves all as it was. */
static int follow_course(struct lx_courses *self, dg_ns now, struct lx_error *error)
{
    struct dg_rig *rig = self->rig->control;
    struct dg_course *course = &self->next.course.course;
    struct place *place = &self->places[self->next.course.quantity];
    course->points = self->next.points;
    /* The rest was checked line by line, or by the command; millions of points take their time. */
    if (course->loop && course->points[course->count - 1u].at == 0) {
        (void)lx_fail(error, "a loop needs a time above 0");
        return WORDS;
    }
    if (!has_course_room(self)) {
        (void)lx_fail(error, "[rig] memory has %llu bytes for courses",
                      (unsigned long long)self->rig->setup.plan->course_memory);
        return NO_ROOM;
    }
    dg_rig_unfollow(rig, self->encoder, self->next.course.quantity);
    empty(place);
    *place = self->next;
    place->lent = true;
    self->next = (struct place){.points = NULL};
    return dg_rig_follow(rig, self->encoder, &place->course, now) == 0 ? 0 : WORDS;
}

static int take_wish_points(struct place *next, const struct dg_rig_course_wish *wish,
                            struct lx_error *error)
{
    next->points = calloc(wish->count, sizeof *next->points);
    if (next->points == NULL) {
        (void)lx_fail(error, "no memory for a course");
        return WORDS;
    }
    memcpy(next->points, wish->points, wish->count * sizeof *next->points);
    next->course.course.count = wish->count;
    return 0;
}

/* @return as read_slice() */
static int begin_course(struct lx_courses *self, const struct dg_rig_course_wish *wish,
                        struct lx_error *error)
{
    struct dg_course_words words;
    if (read_course_words(&self->next, wish, &words, error) != 0) {
        return WORDS;
    }
    return wish->path == NULL ? take_wish_points(&self->next, wish, error)
                              : open_file(self, self->rig->folder, wish, words.name, error);
}

/* Follow what is complete. @return what the client is told */
static int go_on(struct lx_courses *self, int result, dg_ns now, struct lx_error *error,
                 char *detail)
{
    static const int codes[] = {
        [-WORDS] = DG_SCPI_ILLEGAL,
        [-FROM_FILE] = DG_SCPI_FILE_NAME,
        [-BUSY] = DG_SCPI_CONFLICT,
        [-NO_ROOM] = DG_SCPI_MEMORY,
    };
    result = result == 0 ? follow_course(self, now, error) : result;
    if (result > 0) {
        return DG_RIG_READS;
    }
    if (result != BUSY) {
        read_none(self);
    }
    return result == 0 ? 0 : lx_rig_refuse(codes[-result], error, detail);
}

int lx_rig_course(struct dg_rig *control, struct dg_encoder *encoder,
                  const struct dg_rig_course_wish *wish, dg_ns now, char *detail)
{
    struct lx_error error;
    struct lx_courses *self =
        courses_of(lx_rig_of(control), dg_engine_index(control, encoder), &error);
    if (self == NULL) {
        return lx_rig_refuse(DG_SCPI_ILLEGAL, &error, detail);
    }
    if (self->reading != NULL) {
        (void)lx_fail(&error, "another client's file is being read for it");
        return go_on(self, BUSY, now, &error, detail);
    }
    return go_on(self, begin_course(self, wish, &error), now, &error, detail);
}

int lx_rig_course_more(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now, bool gone,
                       char *detail)
{
    struct lx_courses *self = lx_rig_of(control)->courses[dg_engine_index(control, encoder)];
    struct lx_error error;
    if (gone) {
        read_none(self);
        return 0;
    }
    return go_on(self, read_slice(self, &error), now, &error, detail);
}

const char *lx_rig_course_text(struct dg_rig *control, const struct dg_encoder *encoder,
                               size_t quantity)
{
    const struct lx_rig *self = lx_rig_of(control);
    const char *text = self->courses[dg_engine_index(control, encoder)]->places[quantity].text;
    return text == NULL ? "" : text;
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
