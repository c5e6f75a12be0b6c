/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Courses of an encoder's world: their points, and files that are being read for them. The core
 * lets the world follow them (drehgeber/control.h).
 */
#ifndef DREHGEBER_LINUX_COURSES_H
#define DREHGEBER_LINUX_COURSES_H

#include "course_words.h"
#include "drehgeber/control.h"

/** The courses of one encoder. */
struct lx_courses;

/** None so far. @return NULL without memory */
struct lx_courses *lx_courses_new(void);

/** Give them back; the encoder follows none any more. NULL is fine. */
void lx_courses_free(struct lx_courses *self, struct dg_encoder *encoder);

/** What may be wrong. */
enum lx_courses_failure {
    LX_COURSES_WORDS = -1, /**< not a course */
    LX_COURSES_FILE = -2,  /**< the file cannot be read, or what is in it */
    LX_COURSES_BUSY = -3,  /**< another file is being read for this encoder */
};

/** A course that was asked for. */
struct lx_courses_setup {
    struct dg_rig *rig;
    struct dg_encoder *encoder;
    const struct lx_folder *folder; /**< of who names a file in it; NULL: anywhere */
};

/** A course of the plan: all of the file `path`, as DG_COURSE_FORM; who asked lets the encoder
 * follow it. @return NULL with `error`, and why (enum lx_courses_failure) in `failure` */
struct dg_rig_course *lx_courses_read(struct lx_courses *self, size_t quantity, const char *path,
                                      int *failure, struct lx_error *error);

/** Let it follow `wish`. @return 0; 1: a file is being read, lx_courses_read_on(); or enum
 * lx_courses_failure with `error` */
int lx_courses_begin(struct lx_courses *self, const struct lx_courses_setup *setup,
                     const struct dg_rig_course_wish *wish, dg_ns now, struct lx_error *error);

/** Read a slice, and let it follow that from `now` on at the end. @return as above */
int lx_courses_read_on(struct lx_courses *self, const struct lx_courses_setup *setup, dg_ns now,
                       struct lx_error *error);

/** What was being read is not. */
void lx_courses_read_none(struct lx_courses *self);

/** What it follows, as a setting says it; "points". */
const char *lx_courses_text(const struct lx_courses *self, size_t quantity);

#endif
