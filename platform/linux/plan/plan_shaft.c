/* SPDX-License-Identifier: MIT */
/* [shaft NAME] of a rig file. */
#define _GNU_SOURCE
#include "plan_section.h"

#include <string.h>

#include "drehgeber/shaft.h"
#include "figure.h"
#include "motion_words.h"

int lx_plan_find_shaft(const struct lx_plan *plan, const char *name)
{
    return lx_plan_names_find(&plan->names,
                              &(struct lx_plan_name){.list = LX_PLAN_SHAFT, .text = name});
}

/* One number of a ratio up to `end`. */
static bool take_turns(const char *text, size_t n, int32_t *turns)
{
    struct lx_decimal number;
    if (!lx_decimal_parse(text, n, 0, &number) || number.cut || memchr(text, '.', n) != NULL ||
        number.value == 0 || number.value < -INT32_MAX || number.value > INT32_MAX) {
        return false;
    }
    *turns = (int32_t)number.value;
    return true;
}

/* The sign goes to the first number. */
static int take_ratio(const struct lx_plan *plan, const struct lx_plan_setting *row,
                      int32_t ratio[2], struct lx_error *error)
{
    const size_t n = strcspn(row->value, ":");
    if (row->value[n] == '\0' || !take_turns(row->value, n, &ratio[0]) ||
        !take_turns(row->value + n + 1, strlen(row->value + n + 1), &ratio[1])) {
        return lx_plan_wrong_word(plan, row, error,
                                  "TURNS:TURNS with whole numbers other than 0 is right",
                                  "%s is no ratio", row->value);
    }
    if (ratio[1] < 0) {
        ratio[0] = -ratio[0];
        ratio[1] = -ratio[1];
    }
    return 0;
}

static unsigned gears_below(const struct lx_plan *plan, int shaft)
{
    unsigned gears = 0;
    for (int at = plan->shafts[shaft].driver; at >= 0; at = plan->shafts[at].driver) {
        gears++;
    }
    return gears;
}

static int take_driver(const struct lx_plan *plan, const struct lx_plan_setting *row, int *driver,
                       struct lx_error *error)
{
    *driver = lx_plan_find_shaft(plan, row->value);
    if (*driver < 0) {
        return lx_plan_wrong_word(plan, row, error, "the NAME of a [shaft] above is right",
                                  "no shaft %s so far", row->value);
    }
    return gears_below(plan, *driver) < DG_SHAFT_GEARS_MAX
               ? 0
               : lx_plan_wrong_word(plan, row, error, "a shaft with fewer is right",
                                    "%u gears are between %s and what drives it",
                                    DG_SHAFT_GEARS_MAX, row->value);
}

/* Words are understood here; a file is only read when the rig is made. */
static int check_motion(const struct lx_plan *plan, const struct lx_plan_setting *row,
                        struct lx_error *error)
{
    struct lx_shaft motion;
    if (lx_shaft_is_file(row->value)) {
        return 0;
    }
    if (lx_shaft_parse(&motion, row->value, NULL, error) != 0) {
        return lx_plan_refuse_key(plan, row->key, row->line, error);
    }
    lx_shaft_free(&motion);
    return 0;
}

static int check_shaft(const struct lx_plan *plan, const struct lx_plan_section *self,
                       struct lx_error *error)
{
    const struct lx_plan_setting *motion = lx_plan_word(self, "motion");
    const struct lx_plan_setting *driver = lx_plan_word(self, "driver");
    const struct lx_plan_setting *ratio = lx_plan_word(self, "ratio");
    const int same = lx_plan_find_shaft(plan, self->name);
    if (plan->shaft_count > 0 && plan->shafts[0].line == 0) {
        return lx_plan_wrong_section(plan, self, error, "shafts before all encoders are right",
                                     "[encoder %s] above has done without a shaft",
                                     plan->encoders[0].name);
    }
    if (same >= 0) {
        return lx_plan_taken(plan, self, plan->shafts[same].line, error);
    }
    if (motion != NULL && driver != NULL) {
        return lx_plan_wrong_word(plan, motion, error, "one of them is right",
                                  "the driver in line %u turns this shaft", driver->line);
    }
    if (ratio != NULL && driver == NULL) {
        return lx_plan_wrong_word(plan, ratio, error, "driver = NAME of a [shaft] above is right",
                                  "without a driver");
    }
    return motion == NULL ? 0 : check_motion(plan, motion, error);
}

int lx_plan_take_shaft(struct lx_plan *plan, const struct lx_plan_section *self,
                       struct lx_error *error)
{
    const struct lx_plan_setting *motion = lx_plan_word(self, "motion");
    const struct lx_plan_setting *driver = lx_plan_word(self, "driver");
    const struct lx_plan_setting *ratio = lx_plan_word(self, "ratio");
    int drives = -1;
    int32_t turns[2] = {1, 1};
    if (check_shaft(plan, self, error) != 0 ||
        (driver != NULL && take_driver(plan, driver, &drives, error) != 0) ||
        (ratio != NULL && take_ratio(plan, ratio, turns, error) != 0)) {
        return -1;
    }
    const int at = lx_plan_add_shaft(plan, self->name, NULL);
    if (at < 0) {
        return lx_plan_no_room(plan, self, error);
    }
    struct lx_plan_shaft *shaft = &plan->shafts[at];
    shaft->line = self->line;
    shaft->driver = drives;
    memcpy(shaft->ratio, turns, sizeof turns);
    if (motion == NULL) {
        return 0;
    }
    shaft->motion_line = motion->line;
    return lx_shaft_is_file(motion->value)
               ? lx_plan_take_path(plan, motion->value, &shaft->motion, error)
               : lx_plan_take_text(motion, &shaft->motion, error);
}
