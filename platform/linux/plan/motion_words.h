/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A motion in words, see dg_motion_read(), or of a file: FILE.csv. Courses, see dg_course_read(),
 * are always of files: lines `time_s,VALUE`, as the setting of the quantity takes VALUE.
 */
#ifndef DREHGEBER_LINUX_MOTION_WORDS_H
#define DREHGEBER_LINUX_MOTION_WORDS_H

#include "csv.h"
#include "drehgeber/course.h"
#include "drehgeber/motion.h"
#include "drehgeber/rig.h"
#include "file.h"

/** A motion and the points it borrows. */
struct lx_shaft {
    struct dg_motion motion;        /**< starts at 0; the host moves `start` */
    struct dg_motion_point *points; /**< owned; NULL unless it came from a file */
};

/** What lx_shaft_parse() says when it fails. */
enum lx_shaft_failure {
    LX_SHAFT_WORDS = -1, /**< not a motion */
    LX_SHAFT_FILE = -2,  /**< the file cannot be read, or what is in it */
};

/**
 * Parse `text`; a file name is read.
 * @return 0, or enum lx_shaft_failure with one line in `error` and nothing to free
 */
int lx_shaft_parse(struct lx_shaft *self, const char *text, const struct lx_folder *folder,
                   struct lx_error *error);

/** Read a slice of a motion file (lx_csv_motion), which takes about 0.1 ms. @return 1: there is
 * more; 0: `to` is the motion; or enum lx_shaft_failure with one line in `error` */
int lx_shaft_read_on(struct lx_csv *file, struct lx_shaft *to, struct lx_error *error);

/** Give back the points. */
void lx_shaft_free(struct lx_shaft *self);

/** Begin to read `path` for `quantity` (enum dg_quantity_id): its points are struct
 * dg_course_point. @return NULL with one line in `error` */
struct lx_csv *lx_course_open(const char *path, size_t quantity, const struct lx_folder *folder,
                              struct lx_error *error);

#endif
