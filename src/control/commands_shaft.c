/* SPDX-License-Identifier: MIT */
/*
 * SHAFt: the shaft that the selected encoder sits on.
 */
#include "control_private.h"

/* Counts of dg_angle_counts() in a turn: degrees with 6 decimals. */
#define MICRODEGREES 360000000u
#define MICRODEGREE_PLACES 6u
#define MILLI_PLACES 3u
/* Both ends of what is taken are far from where an angle wraps. */
#define ANGLE_MAX (DG_TURN << 30)
#define MOVE_MRPM_DEFAULT 60000
#define RECORD_DEFAULT DG_MS(1)
#define RECORD_MIN DG_US(100)
#define RECORD_MAX DG_S(3600)

static const struct dg_scpi_range angles = {DG_SCPI_ANGLE, 0, -ANGLE_MAX, ANGLE_MAX};
static const struct dg_scpi_range speeds = {DG_SCPI_SPEED, 0, -DG_MOTION_SPEED_MAX_MRPM,
                                            DG_MOTION_SPEED_MAX_MRPM};
static const struct dg_scpi_range ways = {DG_SCPI_SPEED, 0, 1, DG_MOTION_SPEED_MAX_MRPM};
static const struct dg_scpi_range accelerations = {DG_SCPI_ACCELERATION, 0, 0,
                                                   DG_SHAFT_ACCELERATION_MAX};
static const struct dg_scpi_range intervals = {DG_SCPI_TIME, 0, (int64_t)RECORD_MIN,
                                               (int64_t)RECORD_MAX};

static struct dg_rig_shaft *selected_shaft_of(const struct dg_scpi *self)
{
    return dg_control_selected(self)->shaft;
}

/* The shaft, which the command at hand turns otherwise. */
static struct dg_rig_shaft *shaft_to_turn(const struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    struct dg_rig_shaft *shaft = selected_shaft_of(self);

    if (rig->ops->turns != NULL) {
        rig->ops->turns(rig, shaft, self->now);
    }
    return shaft;
}

/* What a command to the shaft gave. */
static void report_shaft(struct dg_scpi *self, int result)
{
    struct dg_rig *rig = dg_control_rig_of(self);

    if (result != DG_OK) {
        dg_scpi_raise(self, DG_SCPI_CONFLICT, "a geared shaft is turned by its driver");
    } else if (rig->ops->turned != NULL) {
        rig->ops->turned(rig, selected_shaft_of(self), self->now);
    } else {
        rig->ops->changed(rig, NULL, self->now);
    }
}

void dg_control_shafts(struct dg_scpi *self)
{
    const struct dg_rig *rig = dg_control_rig_of(self);

    for (size_t i = 0; i < rig->shaft_count; i++) {
        dg_scpi_put_string(self, rig->shafts[i]->name);
    }
}

void dg_control_shaft_name(struct dg_scpi *self)
{
    dg_scpi_put_string(self, selected_shaft_of(self)->name);
}

void dg_control_set_position(struct dg_scpi *self)
{
    int64_t angle;

    if (dg_scpi_number(self, &angles, &angle)) {
        report_shaft(self, dg_shaft_set_position(&shaft_to_turn(self)->shaft, self->now, angle));
    }
}

void dg_control_position(struct dg_scpi *self)
{
    const dg_angle angle = dg_shaft_angle(&selected_shaft_of(self)->shaft, self->now);

    /* To the nearest: an angle behind a gear is rounded down to what is next to it. */
    const int64_t halves = dg_angle_counts(angle, 2u * MICRODEGREES);

    dg_scpi_put_number(self, (halves + (halves & 1)) / 2, MICRODEGREE_PLACES);
}

void dg_control_set_velocity(struct dg_scpi *self)
{
    int64_t mrpm;

    if (dg_scpi_number(self, &speeds, &mrpm)) {
        report_shaft(self,
                     dg_shaft_set_velocity(&shaft_to_turn(self)->shaft, self->now, (int32_t)mrpm));
    }
}

void dg_control_velocity(struct dg_scpi *self)
{
    dg_scpi_put_number(self, dg_shaft_mrpm(&selected_shaft_of(self)->shaft, self->now),
                       MILLI_PLACES);
}

void dg_control_set_acceleration(struct dg_scpi *self)
{
    int64_t mrpm_per_s;

    if (dg_scpi_number(self, &accelerations, &mrpm_per_s)) {
        report_shaft(self, dg_shaft_set_acceleration(&shaft_to_turn(self)->shaft, mrpm_per_s));
    }
}

void dg_control_acceleration(struct dg_scpi *self)
{
    dg_scpi_put_number(self, selected_shaft_of(self)->shaft.mrpm_per_s, MILLI_PLACES);
}

void dg_control_stop(struct dg_scpi *self)
{
    report_shaft(self, dg_shaft_set_velocity(&shaft_to_turn(self)->shaft, self->now, 0));
}

void dg_control_move(struct dg_scpi *self)
{
    int64_t mrpm = MOVE_MRPM_DEFAULT;
    int64_t angle;

    if (!dg_scpi_number(self, &angles, &angle) ||
        (dg_scpi_more(self) && !dg_scpi_number(self, &ways, &mrpm))) {
        return;
    }
    report_shaft(self, dg_shaft_move(&shaft_to_turn(self)->shaft, self->now, angle, (int32_t)mrpm));
}

void dg_control_moving(struct dg_scpi *self)
{
    dg_scpi_put_unsigned(self,
                         dg_shaft_settled(&selected_shaft_of(self)->shaft) > self->now ? 1 : 0);
}

/* What is played never settles, and nobody waits for it. */
dg_ns dg_control_settled(struct dg_scpi *self)
{
    const struct dg_rig *rig = dg_control_rig_of(self);
    dg_ns latest = 0;

    for (size_t i = 0; i < rig->shaft_count; i++) {
        const dg_ns moment = dg_shaft_settled(&rig->shafts[i]->shaft);
        if (moment != DG_NEVER && moment > latest) {
            latest = moment;
        }
    }
    return latest;
}

/* What the host has said to a profile. @return whether it is through with it */
static bool finish_profile(struct dg_scpi *self, int code, const char *detail)
{
    if (code == DG_RIG_READS) {
        return false;
    }
    dg_scpi_raise(self, code, detail);
    if (code == DG_SCPI_NO_ERROR) {
        report_shaft(self, DG_OK);
    }
    return true;
}

/* The session has the same encoder selected as long as the command lasts. */
static bool read_on(struct dg_scpi *self, bool gone)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    char detail[CONTROL_DETAIL_SIZE] = "";
    const int code = rig->ops->profile_more(rig, shaft_to_turn(self), self->now, gone, detail);

    return gone || finish_profile(self, code, detail);
}

void dg_control_set_profile(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    char text[DG_SCPI_LINE_MAX + 1u];
    char detail[CONTROL_DETAIL_SIZE] = "";

    if (!dg_scpi_text(self, text, sizeof text)) {
        return;
    }
    if (rig->ops->profile == NULL) {
        dg_scpi_raise(self, DG_SCPI_MISSING_HARDWARE, NULL);
        return;
    }
    const int code = rig->ops->profile(rig, shaft_to_turn(self), self->now, text, detail);
    if (!finish_profile(self, code, detail)) {
        dg_scpi_hold(self, read_on);
    }
}

void dg_control_profile(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);

    if (rig->ops->profile_text == NULL) {
        dg_scpi_raise(self, DG_SCPI_MISSING_HARDWARE, NULL);
        return;
    }
    dg_scpi_put_string(self, rig->ops->profile_text(rig, selected_shaft_of(self)));
}

static void record(struct dg_scpi *self, const char *path, dg_ns interval)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    char detail[CONTROL_DETAIL_SIZE] = "";

    if (rig->ops->record == NULL) {
        dg_scpi_raise(self, DG_SCPI_MISSING_HARDWARE, NULL);
        return;
    }
    const int code =
        rig->ops->record(rig, selected_shaft_of(self), self->now, path, interval, detail);
    dg_scpi_raise(self, code, detail);
}

void dg_control_record(struct dg_scpi *self)
{
    char path[DG_SCPI_LINE_MAX + 1u];
    int64_t interval = (int64_t)RECORD_DEFAULT;

    if (!dg_scpi_text(self, path, sizeof path) ||
        (dg_scpi_more(self) && !dg_scpi_number(self, &intervals, &interval))) {
        return;
    }
    record(self, path, (dg_ns)interval);
}

void dg_control_record_stop(struct dg_scpi *self)
{
    record(self, NULL, RECORD_DEFAULT);
}
