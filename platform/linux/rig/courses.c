/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "courses.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/quantity.h"

/* One that is followed. */
struct place {
    struct dg_rig_course course;
    struct dg_course_point *points; /* owned, as is the text */
    char *text;
};

struct lx_courses {
    struct place places[DG_QUANTITY_COUNT];
    struct lx_csv *reading; /* NULL: none */
    struct place next;      /* what is being read for */
};

struct lx_courses *lx_courses_new(void)
{
    return calloc(1, sizeof(struct lx_courses));
}

static void empty(struct place *place)
{
    free(place->points);
    free(place->text);
    *place = (struct place){.points = NULL};
}

void lx_courses_read_none(struct lx_courses *self)
{
    lx_csv_close(self->reading);
    self->reading = NULL;
    empty(&self->next);
}

void lx_courses_free(struct lx_courses *self, struct dg_encoder *encoder)
{
    if (self == NULL) {
        return;
    }
    lx_courses_read_none(self);
    encoder->courses = NULL;
    for (size_t i = 0; i < DG_QUANTITY_COUNT; i++) {
        empty(&self->places[i]);
    }
    free(self);
}

/* `next` is complete; what cannot be is only found now, and leaves all as it was. */
static int follow(struct lx_courses *self, const struct lx_courses_setup *setup, dg_ns now,
                  struct lx_error *error)
{
    struct dg_course *course = &self->next.course.course;
    struct place *place = &self->places[self->next.course.quantity];
    course->points = self->next.points;
    /* The rest was checked line by line, or by the command; millions of points take their time. */
    if (course->loop && course->points[course->count - 1u].at == 0) {
        return lx_fail(error, "a loop needs a time above 0");
    }
    dg_rig_unfollow(setup->rig, setup->encoder, self->next.course.quantity);
    empty(place);
    *place = self->next;
    self->next = (struct place){.points = NULL};
    return dg_rig_follow(setup->rig, setup->encoder, &place->course, now);
}

/* "FILE.csv,LOOP,STEP" as a setting says it, or "points,LOOP". */
static int describe(struct place *next, const struct dg_rig_course_wish *wish, size_t name,
                    struct lx_error *error)
{
    struct dg_course *course = &next->course.course;
    const bool state = dg_quantities[wish->quantity].unit == DG_UNIT_STATE;
    if (asprintf(&next->text, "%.*s%s%s", (int)name, wish->path == NULL ? "points" : wish->path,
                 course->loop ? ",LOOP" : "", course->steps && !state ? ",STEP" : "") < 0) {
        next->text = NULL;
        return lx_fail(error, "no memory for a course");
    }
    return 0;
}

/* What is asked for, but for the points. */
static int understand(struct place *next, const struct dg_rig_course_wish *wish,
                      struct dg_course_words *words, struct lx_error *error)
{
    const bool state = dg_quantities[wish->quantity].unit == DG_UNIT_STATE;
    *words = (struct dg_course_words){.name = strlen("points")};
    if (wish->path != NULL && lx_course_parse(wish->path, words, error) != 0) {
        return -1;
    }
    next->course.quantity = wish->quantity;
    next->course.course.loop = wish->loop || words->loop;
    next->course.course.steps = wish->steps || words->steps || state;
    return describe(next, wish, words->name, error);
}

static int take_points(struct place *next, const struct dg_rig_course_wish *wish,
                       struct lx_error *error)
{
    next->points = calloc(wish->count, sizeof *next->points);
    if (next->points == NULL) {
        return lx_fail(error, "no memory for a course");
    }
    memcpy(next->points, wish->points, wish->count * sizeof *next->points);
    next->course.course.count = wish->count;
    return 0;
}

/* @return as lx_courses_begin() */
static int open_file(struct lx_courses *self, const struct lx_folder *folder,
                     const struct dg_rig_course_wish *wish, size_t name, struct lx_error *error)
{
    char *path = strndup(wish->path, name);
    if (path == NULL) {
        (void)lx_fail(error, "no memory for a course");
        return LX_COURSES_WORDS;
    }
    self->reading = lx_course_open(path, wish->quantity, folder, error);
    free(path);
    return self->reading == NULL ? LX_COURSES_FILE : 1;
}

int lx_courses_begin(struct lx_courses *self, const struct lx_courses_setup *setup,
                     const struct dg_rig_course_wish *wish, dg_ns now, struct lx_error *error)
{
    struct dg_course_words words;
    int result = -1;
    if (self->reading != NULL) {
        (void)lx_fail(error, "another client's file is being read for it");
        return LX_COURSES_BUSY;
    }
    if (understand(&self->next, wish, &words, error) != 0) {
        result = LX_COURSES_WORDS;
    } else if (wish->path != NULL) {
        result = open_file(self, setup->folder, wish, words.name, error);
    } else {
        result = take_points(&self->next, wish, error) == 0 ? follow(self, setup, now, error)
                                                            : LX_COURSES_WORDS;
    }
    if (result <= 0) {
        lx_courses_read_none(self);
    }
    return result;
}

/* @return 0: all of it is there; as lx_courses_begin() */
static int read_slice(struct lx_courses *self, struct lx_error *error)
{
    const int result = lx_csv_read_on(self->reading, LX_CSV_SLICE, error);
    if (result == 0) {
        const struct lx_csv_points found = lx_csv_take(self->reading);
        self->next.points = found.points;
        self->next.course.course.count = found.count;
    }
    return result < 0 ? LX_COURSES_FILE : result;
}

struct dg_rig_course *lx_courses_read(struct lx_courses *self, size_t quantity, const char *path,
                                      int *failure, struct lx_error *error)
{
    const struct dg_rig_course_wish wish = {.quantity = quantity, .path = path};
    struct place *place = &self->places[quantity];
    struct dg_course_words words;
    int result = understand(&self->next, &wish, &words, error) != 0
                     ? LX_COURSES_WORDS
                     : open_file(self, NULL, &wish, words.name, error);
    while (result > 0) {
        result = read_slice(self, error);
    }
    if (result == 0) {
        *place = self->next;
        place->course.course.points = place->points;
        self->next = (struct place){.points = NULL};
    }
    lx_courses_read_none(self);
    *failure = result;
    return result == 0 ? &place->course : NULL;
}

int lx_courses_read_on(struct lx_courses *self, const struct lx_courses_setup *setup, dg_ns now,
                       struct lx_error *error)
{
    int result = read_slice(self, error);
    if (result == 0 && follow(self, setup, now, error) != 0) {
        result = LX_COURSES_WORDS;
    }
    if (result <= 0) {
        lx_courses_read_none(self);
    }
    return result;
}

const char *lx_courses_text(const struct lx_courses *self, size_t quantity)
{
    const char *text = self->places[quantity].text;
    return text == NULL ? "" : text;
}
