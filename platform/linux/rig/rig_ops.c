/* SPDX-License-Identifier: MIT */
/* What the control plane asks of a rig: everything that is the port's and not the core's. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/cia406.h"
#include "rig_parts.h"

/* --- helpers --- */

static struct lx_rig_wire *wire_of(struct dg_rig *control, const struct dg_encoder *encoder)
{
    const struct lx_station *station = lx_engine_station(control, encoder);
    return &lx_rig_of(control)->wires[station->plan->wire];
}

static struct lx_rig_shaft *rig_shaft_of(struct dg_rig *control, const struct dg_rig_shaft *shaft)
{
    return &lx_rig_of(control)->shafts[dg_engine_shaft_index(control, shaft)];
}

/* The answer to a command: what was wrong goes with it as far as there is room. */
static int refuse_command(enum dg_scpi_error code, char *detail, const char *text)
{
    (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "%.*s", (int)DG_SCPI_DETAIL_MAX, text);
    return code;
}

static void tell_bus(const struct lx_rig_wire *self, dg_ns now)
{
    if (self->bus->ops->changed != NULL) {
        self->bus->ops->changed(self->bus, NULL, now);
    }
}

/* What is recorded is written as long as the shaft still knows where it was, and clients that wait
   look anew. */
static void note_change(struct lx_rig *self, dg_ns now)
{
    for (size_t i = 0; self->recorded > 0 && i < self->setup.plan->shaft_count; i++) {
        lx_record_write(self->shafts[i].record, now);
    }
    for (size_t i = 0; i < DG_PLAN_CONTROLS_MAX; i++) {
        lx_server_wake(self->servers[i]);
    }
}

/* The clock has changed: for everybody. */
static void change_all(struct lx_rig *self, dg_ns now)
{
    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        tell_bus(&self->wires[i], now);
    }
    note_change(self, now);
}

void lx_rig_settle(void *ctx, dg_ns now)
{
    struct lx_rig *self = ctx;
    const dg_ns next = dg_rig_step(self->control, now);
    lx_timer_at(&self->faults, lx_clock_real(&self->clock, next));
}

/* --- encoders --- */

static void look_at_encoder(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now)
{
    struct lx_bus *bus = lx_engine_station(control, encoder)->bus;
    if (bus->ops->look != NULL) {
        bus->ops->look(bus, now);
    }
}

/* A fault may have come or gone: the timer comes round at once and finds its duration, which
   cannot be looked for here, as dg_rig_step() may be what calls. */
static void changed(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now)
{
    struct lx_rig *self = lx_rig_of(control);
    struct lx_station *station = lx_engine_station(control, encoder);
    if (station->bus->ops->changed != NULL) {
        station->bus->ops->changed(station->bus, station, now);
    }
    lx_timer_at(&self->faults, lx_now());
}

static const char *wire(struct dg_rig *control, const struct dg_encoder *encoder)
{
    return lx_rig_address(lx_rig_of(control), lx_engine_station(control, encoder));
}

static void counters(struct dg_rig *control, const struct dg_encoder *encoder, struct dg_scpi *to)
{
    const struct lx_station *station = lx_engine_station(control, encoder);
    if (station->bus->ops->counters != NULL) {
        station->bus->ops->counters(station->bus, station, to);
    }
    if (station->queue != NULL) {
        dg_state_number(to, "nvm_waits", station->queue->waits);
    }
    lx_rig_count_courses(encoder, to);
}

/* --- shafts --- */

static void turns(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now)
{
    const struct lx_rig_shaft *self = rig_shaft_of(control, shaft);
    for (size_t i = 0; i < self->minder_count; i++) {
        self->minders[i]->bus->ops->turns(self->minders[i]->bus, now);
    }
}

static void turned(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now)
{
    struct lx_rig_shaft *self = rig_shaft_of(control, shaft);
    self->turns++;
    for (size_t i = 0; i < self->minder_count; i++) {
        tell_bus(self->minders[i], now);
    }
    note_change(lx_rig_of(control), now);
}

static bool borrows(const struct dg_shaft_course *course, const struct lx_shaft *motion)
{
    return course->plays && motion->points != NULL && course->motion.points == motion->points;
}

/* A place for a motion whose points nobody looks at any more; what was there is given back. */
static struct lx_shaft *find_motion_place(struct lx_rig_shaft *self)
{
    const struct dg_shaft *shaft = &self->control->shaft;
    struct lx_shaft *at = self->motion;
    while (borrows(&shaft->course, at) || borrows(&shaft->before, at)) {
        at++; /* ends within the array: only two motions can be borrowed from */
    }
    lx_shaft_free(at);
    return at;
}

/* `motion` stands in its place, `text` is what it was made of: both are the shaft's from here on.
 */
static int play_motion(struct lx_rig_shaft *self, dg_ns now, struct lx_shaft *motion, char *text,
                       struct lx_error *error)
{
    if (dg_shaft_play(&self->control->shaft, now, &motion->motion) != DG_OK) {
        lx_shaft_free(motion);
        free(text);
        (void)lx_fail(error, "%s is geared: its driver turns it", self->control->name);
        return LX_SHAFT_WORDS;
    }
    free(self->text);
    self->text = text;
    return 0;
}

/* Words, not a file. @return 0, or enum lx_shaft_failure with `error` */
static int play_words(struct lx_rig_shaft *self, dg_ns now, const char *text,
                      struct lx_error *error)
{
    struct lx_shaft *motion = find_motion_place(self);
    char *copy = strdup(text);
    const int result = copy == NULL ? lx_fail(error, "no memory for %s", text)
                                    : lx_shaft_parse(motion, text, NULL, error);
    if (result != 0) {
        free(copy);
        return result;
    }
    return play_motion(self, now, motion, copy, error);
}

/* --- files of clients: a slice in each turn of the loop, so that the wires have theirs --- */

void lx_rig_read_none(struct lx_rig_shaft *self)
{
    lx_csv_close(self->reading);
    free(self->reads);
    self->reading = NULL;
    self->reads = NULL;
}

/* @return as lx_shaft_read_on() */
static int begin_reading(struct lx_rig_shaft *self, const char *text,
                         const struct lx_folder *folder, struct lx_error *error)
{
    self->reads = strdup(text);
    if (self->reads == NULL) {
        return lx_fail(error, "no memory for %s", text);
    }
    self->reading = lx_csv_open(text, folder, &lx_csv_motion, error);
    if (self->reading == NULL) {
        lx_rig_read_none(self);
        return LX_SHAFT_FILE;
    }
    return 1;
}

static int continue_reading(struct lx_rig_shaft *self, dg_ns now, struct lx_error *error)
{
    struct lx_shaft motion;
    int result = lx_shaft_read_on(self->reading, &motion, error);
    if (result == 0) {
        struct lx_shaft *at = find_motion_place(self);
        *at = motion;
        result = play_motion(self, now, at, self->reads, error);
        self->reads = NULL;
    }
    if (result <= 0) {
        lx_rig_read_none(self);
    }
    return result;
}

int lx_rig_refuse(int code, const struct lx_error *error, char *detail)
{
    const struct lx_words reason = lx_error_reason(error);
    const bool fits = strlen(reason.text) <= DG_SCPI_DETAIL_MAX;
    return refuse_command((enum dg_scpi_error)code, detail, fits ? reason.text : error->what);
}

static int answer_profile(int result, const struct lx_error *error, char *detail)
{
    if (result >= 0) {
        return result == 0 ? 0 : DG_RIG_READS;
    }
    return lx_rig_refuse(result == LX_SHAFT_FILE ? DG_SCPI_FILE_NAME : DG_SCPI_ILLEGAL, error,
                         detail);
}

static int profile(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now, const char *text,
                   char *detail)
{
    struct lx_error error;
    if (shaft->shaft.driver != NULL) {
        return refuse_command(DG_SCPI_CONFLICT, detail, "geared; its driver turns it");
    }
    struct lx_rig_shaft *self = rig_shaft_of(control, shaft);
    if (self->reading != NULL) {
        return refuse_command(DG_SCPI_CONFLICT, detail,
                              "another client's file is being read for it");
    }
    const struct lx_folder *folder = lx_rig_of(control)->folder;
    const int result = dg_motion_is_file(text) ? begin_reading(self, text, folder, &error)
                                               : play_words(self, now, text, &error);
    return answer_profile(result, &error, detail);
}

static int profile_more(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now, bool gone,
                        char *detail)
{
    struct lx_rig_shaft *self = rig_shaft_of(control, shaft);
    struct lx_error error;
    if (gone) {
        lx_rig_read_none(self);
        return 0;
    }
    return answer_profile(continue_reading(self, now, &error), &error, detail);
}

static const char *profile_text(struct dg_rig *control, const struct dg_rig_shaft *shaft)
{
    const struct lx_rig_shaft *self = rig_shaft_of(control, shaft);
    if (shaft->shaft.driver != NULL) {
        return "geared";
    }
    const char *text = self->text != NULL ? self->text : self->planned;
    if (shaft->shaft.course.plays && text != NULL) {
        return text;
    }
    const dg_ns now = lx_clock_now(&lx_rig_of(control)->clock);
    return dg_shaft_mrpm(&shaft->shaft, now) == 0 ? "rest" : "steered";
}

static int record(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now, const char *path,
                  dg_ns interval, char *detail)
{
    struct lx_rig *self = lx_rig_of(control);
    struct lx_rig_shaft *part = rig_shaft_of(control, shaft);
    struct lx_error error;
    if (path == NULL) {
        const int result = lx_record_close(part->record, now, &error);
        self->recorded -= part->record != NULL ? 1u : 0u;
        part->record = NULL;
        return result == 0 ? 0 : lx_rig_refuse(DG_SCPI_STORAGE, &error, detail);
    }
    if (part->record != NULL) {
        return refuse_command(DG_SCPI_CONFLICT, detail,
                              "recorded already; SHAFt:RECord:STOP first");
    }
    const struct lx_record_setup setup = {
        .path = path,
        .folder = self->folder,
        .shaft = &shaft->shaft,
        .event = self->setup.event,
        .clock = &self->clock,
        .interval = interval,
    };
    part->record = lx_record_open(&setup, now, &error);
    self->recorded += part->record != NULL ? 1u : 0u;
    return part->record != NULL ? 0 : lx_rig_refuse(DG_SCPI_FILE_ERROR, &error, detail);
}

/* --- wires --- */

int lx_rig_trace(struct lx_rig_wire *self, const char *path, struct lx_error *error)
{
    const struct lx_wire *kind = lx_wire_of(self->plan->kind);
    const struct lx_trace_setup setup = {
        .path = path,
        .folder = self->rig->folder,
        .kind = lx_rig_stack(self->rig, self->bus->setup.index)->trace,
        .words = lx_rig_words(self),
        .wire = kind->where_in_trace ? self->plan->where : self->plan->name,
        .tap = &self->bus->tap,
        .held = !self->rig->stands,
    };
    self->trace = lx_trace_open(&setup, lx_clock_now(&self->rig->clock), error);
    return self->trace == NULL ? -1 : 0;
}

/* Somebody begins to listen to a wire, or ends. */
static void listened(const struct lx_rig_wire *self)
{
    tell_bus(self, lx_clock_now(&self->rig->clock));
}

static int trace(struct dg_rig *control, struct dg_encoder *encoder, const char *path, char *detail)
{
    struct lx_rig_wire *self = wire_of(control, encoder);
    struct lx_error error;
    if (path == NULL) {
        const int result = lx_trace_close(self->trace, &error);
        self->trace = NULL;
        listened(self);
        return result == 0 ? 0 : lx_rig_refuse(DG_SCPI_STORAGE, &error, detail);
    }
    if (self->trace != NULL) {
        return refuse_command(DG_SCPI_CONFLICT, detail, "traced already; TRACe:STOP first");
    }
    if (lx_rig_trace(self, path, &error) != 0) {
        return lx_rig_refuse(DG_SCPI_FILE_ERROR, &error, detail);
    }
    listened(self);
    return 0;
}

/* The first question begins the listening, so it has no answer yet. */
static bool last(struct dg_rig *control, const struct dg_encoder *encoder, unsigned back,
                 struct dg_rig_line *line)
{
    struct lx_rig_wire *self = wire_of(control, encoder);
    struct lx_error error;
    const bool begins = !self->listens;
    if (lx_rig_listen(self, &error) != 0) {
        return false;
    }
    if (begins) {
        listened(self);
    }
    if (back >= LX_RIG_LINES || back >= self->line_count) {
        return false;
    }
    *line = self->lines[(self->line_count - 1u - back) % LX_RIG_LINES];
    return true;
}

/* --- time --- */

static bool simulated(const struct lx_rig *self)
{
    const struct dg_plan *plan = self->setup.plan;
    for (size_t i = 0; i < plan->wire_count; i++) {
        if (!lx_wire_of(plan->wires[i].kind)->simulated) {
            return false;
        }
    }
    return true;
}

static int set_scale(struct dg_rig *control, uint32_t permille, char *detail)
{
    struct lx_rig *self = lx_rig_of(control);
    if (!simulated(self)) {
        return refuse_command(DG_SCPI_CONFLICT, detail,
                              "a wire of this rig runs in real time; expected only sim wires");
    }
    const dg_ns now = lx_clock_now(&self->clock);
    self->clock = (struct lx_clock){.real = lx_now(), .virtual_ = now, .permille = permille};
    change_all(self, now);
    lx_rig_settle(self, now);
    return 0;
}

static uint32_t scale(struct dg_rig *control)
{
    return lx_rig_of(control)->clock.permille;
}

/* Faults end at their own moments on the way. */
static int step_time(struct dg_rig *control, dg_ns span, char *detail)
{
    struct lx_rig *self = lx_rig_of(control);
    struct lx_clock *clock = &self->clock;
    if (!simulated(self) || clock->permille != 0) {
        return refuse_command(DG_SCPI_CONFLICT, detail, "time is not stopped; TIME:SCALe 0 first");
    }
    const dg_ns end = dg_after(clock->virtual_, span);
    while (clock->virtual_ < end) {
        const dg_ns next = dg_rig_step(control, clock->virtual_);
        clock->virtual_ = next > clock->virtual_ ? dg_earliest(next, end) : end;
        change_all(self, clock->virtual_);
    }
    lx_rig_settle(self, end);
    return 0;
}

const struct dg_rig_ops lx_rig_ops = {
    .changed = changed,
    .wire = wire,
    .counters = counters,
    .profile = profile,
    .profile_text = profile_text,
    .record = record,
    .trace = trace,
    .last = last,
    .set_scale = set_scale,
    .scale = scale,
    .step = step_time,
    .look = look_at_encoder,
    .turns = turns,
    .turned = turned,
    .profile_more = profile_more,
    .course = lx_rig_course,
    .course_more = lx_rig_course_more,
    .course_text = lx_rig_course_text,
};
