/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The files of courses: lines `time_s,VALUE`, as the setting of the quantity takes VALUE.
 */
#ifndef DREHGEBER_LINUX_COURSE_WORDS_H
#define DREHGEBER_LINUX_COURSE_WORDS_H

#include <stdbool.h>
#include <stddef.h>

#include "csv.h"
#include "drehgeber/course.h"
#include "drehgeber/rig.h"
#include "file.h"
#include "say.h"

/** dg_course_read(), with an error of this port. @return 0, or -1 with one line in `error` */
int lx_course_parse(const char *text, struct dg_course_words *to, struct lx_error *error);

/** A file that is being read, a slice at a time. */
struct lx_course_file;

/** Begin to read `path` for `quantity` (enum dg_quantity_id). @return NULL with one line in
 * `error` */
struct lx_course_file *lx_course_file_open(const char *path, size_t quantity,
                                           const struct lx_folder *folder, struct lx_error *error);

/** Read a slice. @return 1: there is more; 0: `to` has the points (struct dg_course_point); -1 with
 * one line in `error` */
int lx_course_file_read(struct lx_course_file *self, struct lx_csv_points *to,
                        struct lx_error *error);

/** End; NULL is fine. */
void lx_course_file_close(struct lx_course_file *self);

#endif
