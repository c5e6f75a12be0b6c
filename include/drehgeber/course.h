/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A course: what a quantity of the world is over time, by points. Between two of them it goes
 * straight, or holds; two points of one moment are a step. Exact in integers, and a pure function
 * of time: who looks late sees what he would have seen in time.
 *
 * Between points the quantity is what the line was at the last whole millisecond of the course's
 * time (in a loop: of the lap's), rounded to the unit it is counted in, halves away from the point
 * before. At the moment of a point it is that point, also between two milliseconds; of several the
 * last one counts. So it changes at most once a millisecond and at points, and never to anything
 * that it cannot be.
 */
#ifndef DREHGEBER_COURSE_H
#define DREHGEBER_COURSE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Between points: at most one change in such a span. */
#define DG_COURSE_GRID DG_MS(1)

/** A point. */
struct dg_course_point {
    dg_ns at;      /**< since the course began */
    int32_t value; /**< in the quantity's unit; any two lie less than 2^31 apart */
};

/** A course; the points are borrowed. */
struct dg_course {
    const struct dg_course_point *points;
    size_t count; /**< at least 1 */
    bool loop;    /**< again and again: the moment of the last point is 0 of the next lap; until the
                       first point of that lap it stays what the last one says */
    bool steps;   /**< hold each point up to the next one */
};

/** Whether the course can be. @return 0, or DG_ERR_ARGUMENT: no points, a point earlier than the
 * one before it, or a loop whose last point is at 0 */
DG_API int dg_course_check(const struct dg_course *self);

/** What it is `since` it began. @return false: the first point is still to come, and `value` is as
 * before. Behind the last point it stays what that says. */
DG_API bool dg_course_at(const struct dg_course *self, dg_ns since, int32_t *value);

/** When it may be something else next, later than `since`; nothing changes before. DG_NEVER: it
 * stays what it is for good. */
DG_API dg_ns dg_course_next(const struct dg_course *self, dg_ns since);

#ifdef __cplusplus
}
#endif

#endif
