/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The files of courses: lines `time_s,VALUE`, as the setting of the quantity takes VALUE.
 */
#ifndef DREHGEBER_LINUX_COURSE_WORDS_H
#define DREHGEBER_LINUX_COURSE_WORDS_H

#include <stddef.h>

#include "csv.h"
#include "drehgeber/course.h"
#include "drehgeber/rig.h"

/** dg_course_read(), with an error of this port. @return 0, or -1 with one line in `error` */
int lx_course_parse(const char *text, struct dg_course_words *to, struct lx_error *error);

/** Begin to read `path` for `quantity` (enum dg_quantity_id): its points are struct
 * dg_course_point. @return NULL with one line in `error` */
struct lx_csv *lx_course_open(const char *path, size_t quantity, const struct lx_folder *folder,
                              struct lx_error *error);

#endif
