/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A course of a quantity of the world in words: FILE.csv[,ONCE|LOOP][,LINEAR|STEP], with lines
 * `time_s,VALUE` as its setting takes VALUE. Words are not case sensitive.
 */
#ifndef DREHGEBER_LINUX_COURSE_WORDS_H
#define DREHGEBER_LINUX_COURSE_WORDS_H

#include <stdbool.h>
#include <stddef.h>

#include "csv.h"
#include "drehgeber/course.h"
#include "file.h"
#include "say.h"

/** The form, for help and errors. */
#define LX_COURSE_FORM "FILE.csv[,ONCE|LOOP][,LINEAR|STEP]"

/** What the words say. */
struct lx_course_words {
    size_t name; /**< characters of the file's name, at the beginning */
    bool loop;
    bool steps;
};

/** Whether `text` is meant for a course: it begins with the name of a CSV file. */
bool lx_course_is(const char *text);

/** Understand them. @return 0, or -1 with one line in `error` */
int lx_course_parse(const char *text, struct lx_course_words *to, struct lx_error *error);

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
