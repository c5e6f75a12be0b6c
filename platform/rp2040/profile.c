/* SPDX-License-Identifier: MIT */
#include "profile.h"

#include <stddef.h>
#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/key.h"
#include "drehgeber/text.h"

#define NUMBER_MAX 16u
#define PARTS_MAX 3u
#define MDEG_PER_TURN 360000

/* What the words of a form give. */
struct figures {
    int32_t mrpm;
    int32_t mdeg;
    dg_ns first;
    dg_ns second;
};

/* clang-format off */
#define AT(field) offsetof(struct figures, field)
#define RPM(to) {"RPM", {.offset = AT(to), .type = DG_KEY_I32, .places = 3, .min = -1000000000, .max = 1000000000}}
#define DEG(to) {"DEG", {.offset = AT(to), .type = DG_KEY_I32, .places = 3, .min = -360000000, .max = 360000000}}
#define S(to) {"S", {.offset = AT(to), .type = DG_KEY_NS, .places = 3, .factor = 1000000, .max = 3600000}}

/* Forms, their parts with the unit of each, and how many there are at least. */
static const struct form {
    const char *word;
    enum dg_motion_kind kind;
    size_t least;
    struct part {
        const char *unit;
        struct dg_key number;
    } parts[PARTS_MAX];
} forms[] = {
    {"sine:", DG_MOTION_SINE, 2, {DEG(mdeg), S(first)}},
    {"ramp:", DG_MOTION_RAMP, 2, {RPM(mrpm), S(first), S(second)}},
    {"", DG_MOTION_SPEED, 1, {RPM(mrpm)}},
};
/* clang-format on */

/* A number and its unit. @return what is behind them and their comma, or NULL */
static const char *read_part(struct figures *to, const struct part *part, const char *text)
{
    const size_t all = strcspn(text, ","), unit = strlen(part->unit);
    char number[NUMBER_MAX];

    if (all <= unit || all - unit >= sizeof number ||
        !dg_text_same(text + all - unit, part->unit, unit, dg_text_upper)) {
        return NULL;
    }
    memcpy(number, text, all - unit);
    number[all - unit] = '\0';
    if (dg_key_set(&part->number, to, number) != DG_OK) {
        return NULL;
    }
    return text[all] == ',' ? text + all + 1 : text + all;
}

static bool read_parts(struct figures *to, const struct form *form, const char *text)
{
    size_t n = 0;

    for (; n < PARTS_MAX && form->parts[n].unit != NULL && *text != '\0'; n++) {
        text = read_part(to, &form->parts[n], text);
        if (text == NULL) {
            return false;
        }
    }
    return *text == '\0' && n >= form->least;
}

bool profile_read(struct dg_motion *to, const char *text)
{
    for (size_t i = 0; i < DG_COUNT(forms); i++) {
        const struct form *form = &forms[i];
        const size_t n = strlen(form->word);
        struct figures figures = {.second = DG_NEVER};
        if (dg_text_same(text, form->word, n, dg_text_upper) &&
            read_parts(&figures, form, text + n)) {
            *to = (struct dg_motion){.kind = form->kind,
                                     .mrpm = figures.mrpm,
                                     .accel = figures.first,
                                     .period = figures.first,
                                     .hold = figures.second,
                                     .amplitude = figures.mdeg * DG_TURN / MDEG_PER_TURN};
            return true;
        }
    }
    return false;
}
