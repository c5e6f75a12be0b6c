/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Recorded motions: text lines `time_s,angle_deg`, both plain decimals. The first line may be a
 * header; empty lines and what follows a # are skipped. Times start at 0 or later and increase.
 * Time is cut to 1 ns, the angle to 10^-9 degree.
 */
#ifndef DREHGEBER_LINUX_CSV_H
#define DREHGEBER_LINUX_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "drehgeber/motion.h"
#include "say.h"

/** The points of a file. */
struct lx_recording {
    struct dg_motion_point *points; /**< malloc()ed, the caller frees */
    size_t count;
};

/** A file that is being read, a slice at a time. */
struct lx_csv;

/** Begin with `file`, borrowed, called `name` in errors. @return NULL without memory */
struct lx_csv *lx_csv_open(FILE *file, const char *name);

/** Read up to `lines` more. @return 1: there are more; 0: that was all, and lx_csv_take() has it;
 * -1 with "name:line: what is wrong" */
int lx_csv_read_on(struct lx_csv *self, unsigned lines, struct lx_error *error);

/** What was found, which is the caller's then. */
struct lx_recording lx_csv_take(struct lx_csv *self);

/** End; NULL is fine. */
void lx_csv_close(struct lx_csv *self);

/**
 * Read all points of `file`, called `name` in errors.
 * @return 0 with one point or more; -1 with "name:line: what is wrong" and nothing to free
 */
int lx_csv_read(struct lx_recording *out, FILE *file, const char *name, struct lx_error *error);

#endif
