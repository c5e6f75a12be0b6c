/* SPDX-License-Identifier: MIT */
/* Words to a course of a quantity; what is in its file is the host's to read. */
#include "drehgeber/hal.h"
#include "rig_private.h"

/* Characters of the name at the beginning; 0: there is none. */
static size_t course_name_length(const char *text)
{
    const size_t n = dg_plan_span(text, ',');

    return dg_plan_ends(text, n, ".csv") ? n : 0;
}

bool dg_course_is(const char *text)
{
    return course_name_length(text) > 0;
}

static bool take_course_word(const char *word, struct dg_course_words *to)
{
    static const char *const words[] = {"once", "loop", "linear", "step"};
    size_t i = 0;

    while (i < DG_COUNT(words) && !dg_plan_same_word(word, words[i])) {
        i++;
    }
    to->loop = to->loop || i == 1u;
    to->steps = to->steps || i == 3u;
    return i < DG_COUNT(words);
}

int dg_course_read(const char *text, struct dg_course_words *to, struct dg_plan_error *error)
{
    *to = (struct dg_course_words){.name = course_name_length(text)};
    if (to->name == 0) {
        (void)dg_plan_refuse(error, RIG_SAY("expected " DG_COURSE_FORM),
                             RIG_SAY("'", text, "' is no CSV file"));
        return DG_ERR_ARGUMENT;
    }
    for (const char *at = text + to->name; at[0] == ','; at += dg_plan_span(at, ',')) {
        at++;
        while (*at == ' ') {
            at++;
        }
        const struct rig_cut word = dg_plan_cut(at, dg_plan_span(at, ','));
        if (!take_course_word(word.text, to)) {
            (void)dg_plan_refuse(error, RIG_SAY("expected " DG_COURSE_FORM),
                                 RIG_SAY("'", word.text, "' is none of the words"));
            return DG_ERR_ARGUMENT;
        }
    }
    return DG_OK;
}
