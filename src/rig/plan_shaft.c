/* SPDX-License-Identifier: MIT */
/* [shaft NAME] of a rig file. */
#include "drehgeber/figure.h"
#include "drehgeber/shaft.h"
#include "rig_private.h"

#include <string.h>

/* One number of a ratio up to `end`. */
static bool take_turns(const char *text, size_t n, int32_t *turns)
{
    struct dg_decimal number;

    if (!dg_decimal_parse(text, n, 0, &number) || number.cut || dg_plan_span(text, '.') < n ||
        number.value == 0 || number.value < -INT32_MAX || number.value > INT32_MAX) {
        return false;
    }
    *turns = (int32_t)number.value;
    return true;
}

/* The sign goes to the first number. */
static int take_ratio(struct rig_reader *in, const struct dg_plan_setting *word, int32_t ratio[2])
{
    const size_t n = dg_plan_span(word->value, ':');
    const char *second = word->value[n] == '\0' ? "" : word->value + n + 1u;

    if (!take_turns(word->value, n, &ratio[0]) ||
        !take_turns(second, dg_plan_length(second), &ratio[1])) {
        return dg_plan_wrong_word(in, word,
                                  RIG_SAY("expected TURNS:TURNS with whole numbers other than 0"),
                                  RIG_SAY(word->value, " is no ratio"));
    }
    if (ratio[1] < 0) {
        ratio[0] = -ratio[0];
        ratio[1] = -ratio[1];
    }
    return 0;
}

static unsigned count_gears(const struct dg_plan *plan, int shaft)
{
    unsigned gears = 0;

    for (int at = plan->shafts[shaft].driver; at >= 0; at = plan->shafts[at].driver) {
        gears++;
    }
    return gears;
}

static int take_driver(struct rig_reader *in, const struct dg_plan_setting *word, int *driver)
{
    *driver = dg_plan_find_shaft(in->plan, word->value);
    if (*driver < 0) {
        return dg_plan_wrong_word(in, word, RIG_SAY("expected the NAME of a [shaft] above"),
                                  RIG_SAY("no shaft ", word->value, " so far"));
    }
    return count_gears(in->plan, *driver) < DG_SHAFT_GEARS_MAX
               ? 0
               : dg_plan_wrong_word(in, word, RIG_SAY("expected a shaft with fewer"),
                                    RIG_SAY(dg_plan_number(DG_SHAFT_GEARS_MAX).text,
                                            " gears are between ", word->value,
                                            " and what drives it"));
}

/* Words are understood here; a file is only read when the rig is made. */
static int check_motion(struct rig_reader *in, const struct dg_plan_setting *word)
{
    struct dg_motion motion;

    return dg_motion_is_file(word->value) || dg_motion_read(&motion, word->value, in->error) == 0
               ? 0
               : dg_plan_refuse_key(in, word->key, word->line);
}

static int check_shaft(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan *plan = in->plan;
    const struct dg_plan_setting *motion = dg_plan_word(self, "motion");
    const struct dg_plan_setting *driver = dg_plan_word(self, "driver");
    const struct dg_plan_setting *ratio = dg_plan_word(self, "ratio");
    const int same = dg_plan_find_shaft(plan, self->name);

    if (plan->shaft_count > 0 && plan->shafts[0].line == 0) {
        return dg_plan_wrong_section(
            in, self, RIG_SAY("expected shafts before all encoders"),
            RIG_SAY("[encoder ", plan->encoders[0].name, "] above has done without a shaft"));
    }
    if (same >= 0) {
        return dg_plan_taken(in, self, plan->shafts[same].line);
    }
    if (motion != NULL && driver != NULL) {
        return dg_plan_wrong_word(in, motion, RIG_SAY("expected one of them"),
                                  RIG_SAY("the driver in line ",
                                          dg_plan_line_text(plan, driver->line, motion->line).text,
                                          " turns this shaft"));
    }
    if (ratio != NULL && driver == NULL) {
        return dg_plan_wrong_word(in, ratio, RIG_SAY("expected driver = NAME of a [shaft] above"),
                                  RIG_SAY("without a driver"));
    }
    return motion == NULL ? 0 : check_motion(in, motion);
}

int dg_plan_take_shaft(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan_setting *motion = dg_plan_word(self, "motion");
    const struct dg_plan_setting *driver = dg_plan_word(self, "driver");
    const struct dg_plan_setting *ratio = dg_plan_word(self, "ratio");
    int drives = -1;
    int32_t turns[2] = {1, 1};

    if (check_shaft(in, self) != 0 || (driver != NULL && take_driver(in, driver, &drives) != 0) ||
        (ratio != NULL && take_ratio(in, ratio, turns) != 0)) {
        return -1;
    }
    const int at = dg_plan_add_shaft(in->plan, self->name, NULL);
    if (at < 0) {
        return -1;
    }
    struct dg_plan_shaft *shaft = &in->plan->shafts[at];
    shaft->line = self->line;
    shaft->driver = drives;
    memcpy(shaft->ratio, turns, sizeof turns);
    if (motion == NULL) {
        return 0;
    }
    shaft->motion_line = motion->line;
    shaft->motion = dg_motion_is_file(motion->value) ? dg_plan_path(in, motion->value, motion->line)
                                                     : motion->value;
    return shaft->motion == NULL ? -1 : 0;
}
