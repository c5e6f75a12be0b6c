/* SPDX-License-Identifier: MIT */
/*
 * WORLd:...:PROFile: what the selected encoder senses over time.
 */
#include "control_private.h"

/* Of a line; a file has as many as it likes. */
#define POINTS_MAX 32u
/* What a point of a file may have for time, too. */
#define TIME_MAX DG_S(9000000000)

static const struct dg_scpi_range times = {DG_SCPI_TIME, 0, 0, (int64_t)TIME_MAX};

static const struct dg_quantity *quantity_of(const struct dg_scpi *self)
{
    return &dg_quantities[self->command->argument];
}

/* ONCE or LOOP, LINear or STEP: behind all else, each at most once, in any order. */
static bool take_course_words(struct dg_scpi *self, struct dg_rig_course_wish *wish)
{
    static const char *const words[] = {"ONCE", "LOOP", "LINear", "STEP"};
    size_t word;

    wish->steps = quantity_of(self)->unit == DG_UNIT_STATE;
    while (dg_scpi_more(self)) {
        if (!dg_scpi_word(self, words, DG_COUNT(words), &word) ||
            !dg_scpi_close(self, DG_SCPI_SYNTAX)) {
            return false;
        }
        wish->loop = wish->loop || word == 1u;
        wish->steps = wish->steps || word == 3u;
    }
    return true;
}

/* What the host has said. @return whether it is through */
static bool followed(struct dg_scpi *self, int code, const char *detail)
{
    if (code == DG_RIG_READS) {
        return false;
    }
    dg_scpi_raise(self, code, detail);
    if (code == DG_SCPI_NO_ERROR) {
        dg_control_changed(self);
    }
    return true;
}

/* The session has the same encoder selected as long as the command lasts. */
static bool read_course_on(struct dg_scpi *self, bool gone)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    char detail[CONTROL_DETAIL_SIZE] = "";
    const int code = rig->ops->course_more(rig, dg_control_selected(self), self->now, gone, detail);

    return gone || followed(self, code, detail);
}

static void start_course(struct dg_scpi *self, const struct dg_rig_course_wish *wish)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    char detail[CONTROL_DETAIL_SIZE] = "";

    if (!control_offered(self, rig->ops->course != NULL)) {
        return;
    }
    const int code = rig->ops->course(rig, dg_control_selected(self), wish, self->now, detail);
    if (!followed(self, code, detail)) {
        dg_scpi_hold(self, read_course_on);
    }
}

void dg_control_follow(struct dg_scpi *self)
{
    char path[DG_SCPI_LINE_MAX + 1u];
    struct dg_rig_course_wish wish = {.quantity = self->command->argument, .path = path};

    if (dg_scpi_text(self, path, sizeof path) && take_course_words(self, &wish)) {
        start_course(self, &wish);
    }
}

static bool take_course_value(struct dg_scpi *self, int32_t *to)
{
    const struct dg_quantity *row = quantity_of(self);
    const struct dg_scpi_range range = dg_control_range(row);
    const bool state = row->unit == DG_UNIT_STATE;
    int64_t value = 0;
    bool flag = false;

    if (state ? !dg_scpi_flag(self, &flag) : !dg_scpi_number(self, &range, &value)) {
        return false;
    }
    *to = state ? flag : (int32_t)value;
    return true;
}

static bool take_point(struct dg_scpi *self, struct dg_course_point *to)
{
    int64_t at = 0;

    if (!dg_scpi_number(self, &times, &at)) {
        return false;
    }
    to->at = (dg_ns)at;
    return take_course_value(self, &to->value);
}

/* @return how many; 0: an error was raised */
static size_t take_points(struct dg_scpi *self, struct dg_course_point points[POINTS_MAX])
{
    size_t count = 0;

    do {
        if (count == POINTS_MAX) {
            dg_scpi_raise(self, DG_SCPI_RANGE, "at most 32 points; a file takes more");
            return 0;
        }
        if (!take_point(self, &points[count])) {
            return 0;
        }
        count++;
    } while (dg_scpi_more(self) && !dg_scpi_at_word(self));
    return count;
}

void dg_control_follow_points(struct dg_scpi *self)
{
    struct dg_course_point points[POINTS_MAX];
    struct dg_rig_course_wish wish = {.quantity = self->command->argument, .points = points};

    wish.count = take_points(self, points);
    if (wish.count == 0 || !take_course_words(self, &wish)) {
        return;
    }
    const struct dg_course course = {.points = points, .count = wish.count, .loop = wish.loop};
    if (dg_course_check(&course) != DG_OK) {
        dg_scpi_raise(self, DG_SCPI_ILLEGAL, "times go on; a loop has one above 0");
        return;
    }
    start_course(self, &wish);
}

void dg_control_followed(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    const struct dg_encoder *encoder = dg_control_selected(self);
    const size_t quantity = self->command->argument;
    const bool there = dg_rig_course_of(encoder, quantity) != NULL && rig->ops->course_text != NULL;

    dg_scpi_put_string(self, there ? rig->ops->course_text(rig, encoder, quantity) : "");
}

/* ON is what it is, or needs to know what to follow. */
void dg_control_follow_on(struct dg_scpi *self)
{
    struct dg_encoder *encoder = dg_control_selected(self);
    const size_t quantity = self->command->argument;
    bool on = false;

    if (!dg_scpi_flag(self, &on)) {
        return;
    }
    if (!on) {
        dg_rig_unfollow(dg_control_rig_of(self), encoder, quantity);
        dg_control_changed(self);
    } else if (dg_rig_course_of(encoder, quantity) == NULL) {
        dg_scpi_raise(self, DG_SCPI_CONFLICT, "PROFile or PROFile:POINts begins one");
    }
}

void dg_control_follows(struct dg_scpi *self)
{
    dg_scpi_put_unsigned(
        self, dg_rig_course_of(dg_control_selected(self), self->command->argument) != NULL);
}

/* clang-format off */
#define WORDS "[,ONCE|LOOP][,LINear|STEP]"
#define FILES(id, member, name, header, ...) \
    {"WORLd:" header ":PROFile", dg_control_follow, dg_control_followed, DG_QUANTITY_##id, "\"FILE.csv\"" WORDS, "let the quantity follow the points of a file; the default is ONCE and LINear"},
#define POINTS(id, member, name, header, ...) \
    {"WORLd:" header ":PROFile:POINts", dg_control_follow_points, NULL, DG_QUANTITY_##id, "TIME,VALUE,..." WORDS, "let the quantity follow these points, at most 32"},
#define STATES(id, member, name, header, ...) \
    {"WORLd:" header ":PROFile:STATe", dg_control_follow_on, dg_control_follows, DG_QUANTITY_##id, "OFF", "whether the quantity follows points; OFF ends this, and the value stays"},

static const struct dg_scpi_command rows[] = {
    /* header, command, query, argument, parameters, help */
    DG_QUANTITIES(FILES)
    DG_QUANTITIES(POINTS)
    DG_QUANTITIES(STATES)
};
/* clang-format on */

const struct dg_scpi_commands dg_course_commands = {rows, DG_COUNT(rows)};
