/* SPDX-License-Identifier: MIT */
/* The file of a rig, see fmu.h: for the sources of this folder only. */
#ifndef DREHGEBER_FMU_BUNDLE_H
#define DREHGEBER_FMU_BUNDLE_H

#include "drehgeber/course.h"
#include "drehgeber/motion.h"
#include "drehgeber/rig.h"

/** Its bytes, with a zero behind them. */
struct fmu_bundle {
    char *text; /* owned */
    size_t n;
};

/** Part `name` of this kind; NULL as name: the first one. Its name is told in `called`, unless that
 * is NULL. @return whether there is one */
bool fmu_bundle_part(const struct fmu_bundle *self, const char *kind, const char *name,
                     struct dg_plan_text *to, struct dg_plan_text *called);

/** The points of the part for this line of the plan, to be freed. @return how many; 0: there are
 * none, or no memory */
size_t fmu_bundle_motion(const struct fmu_bundle *self, dg_plan_line line,
                         struct dg_motion_point **to);
size_t fmu_bundle_course(const struct fmu_bundle *self, dg_plan_line line,
                         struct dg_course_point **to);

#endif
