/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Points over time, recorded motions for one: text lines `time_s,VALUE`, both plain decimals. The
 * first line may be a header; empty lines and what follows a # are skipped. Times start at 0 or
 * later and increase. Time is cut to 1 ns, the value to its last place.
 */
#ifndef DREHGEBER_LINUX_CSV_H
#define DREHGEBER_LINUX_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "drehgeber/motion.h"
#include "file.h"
#include "say.h"

/** Characters of a line without its end, as of a rig file's. */
#define LX_CSV_LINE_MAX 198u

/** Lines to read in one turn of the loop: some ten microseconds. */
#define LX_CSV_SLICE 128u

/** Points that a client's file may have. All of them are looked at once more when they are taken
 * into use, in one go: that takes some two milliseconds. */
#define LX_CSV_CLIENT_MAX ((size_t)1 << 20)

/** What the second column is, and what a point is made of. */
struct lx_csv_kind {
    const char *column;    /**< its name: "angle_deg" */
    struct lx_words value; /**< what is right: "the angle is decimal degrees ..." */
    unsigned places;       /**< that are kept of it */
    int64_t min;           /**< in units of the last place */
    int64_t max;
    bool steps;  /**< a time may be that of the line before */
    size_t size; /**< of a point */
    void (*put)(void *points, size_t index, dg_ns at, int64_t value);
};

/** Motions: struct dg_motion_point; the angle is cut to 10^-9 degree. */
extern const struct lx_csv_kind lx_csv_motion;

/** Points of a kind. */
struct lx_csv_points {
    void *points; /**< malloc()ed, the caller frees */
    size_t count;
};

/** A file that is being read, a slice at a time. */
struct lx_csv;

/** Begin with the file that a user names, or with `folder` a client; that may have
 * LX_CSV_CLIENT_MAX points. @return NULL with one line in `error` */
struct lx_csv *lx_csv_open(const char *path, const struct lx_folder *folder,
                           const struct lx_csv_kind *kind, struct lx_error *error);

/** Begin with `file`, called `name` in errors, which is closed at the end. More than `most` points
 * are refused. @return NULL without memory; then it is closed, too */
struct lx_csv *lx_csv_begin(FILE *file, const char *name, const struct lx_csv_kind *kind,
                            size_t most);

/** Read up to `lines` more. @return 1: there are more; 0: that was all, and lx_csv_take() has it;
 * -1 with "name:line: what is wrong" */
int lx_csv_read_on(struct lx_csv *self, unsigned lines, struct lx_error *error);

/** What was found, which is the caller's then. */
struct lx_csv_points lx_csv_take(struct lx_csv *self);

/** End; NULL is fine. */
void lx_csv_close(struct lx_csv *self);

#endif
