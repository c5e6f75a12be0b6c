/* SPDX-License-Identifier: MIT */
/*
 * make_rig() lets the engine turn the plan into shafts, encoders and wires and touches nothing
 * outside; power_rig() opens what there is outside. Either all of it stands afterwards, or nothing.
 */
#define _GNU_SOURCE
#include "rig.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rig_parts.h"

/* Rigs of one name that have a default control address, at the same time. */
#define SAME_NAME_MAX 64u
/* A process that is held up so long says so, */
#define STALL_TOLD DG_MS(100)
/* and again when it was not for so long. */
#define STALL_EPISODE DG_S(1)

struct lx_rig *lx_rig_of(const struct dg_rig *control)
{
    return lx_engine_of(control)->setup.ctx;
}

/* --- from the plan --- */

/* The motion of a file. */
static int find_motion(void *ctx, size_t index, const char *path, struct dg_motion *to,
                       struct lx_error *error)
{
    struct lx_rig *self = ctx;
    const struct dg_plan *plan = self->setup.plan;
    struct lx_shaft *motion = self->shafts[index].motion;
    if (lx_shaft_parse(motion, path, NULL, error) != 0) {
        self->result = LX_RIG_WORLD;
        return lx_plan_refuse_key(plan, "motion", plan->shafts[index].motion_line, error);
    }
    *to = motion->motion;
    return 0;
}

/* What can be said of a trace before anything is opened. */
static int check_trace(void *ctx, size_t index, struct lx_error *error)
{
    const struct lx_rig *self = ctx;
    const struct dg_plan_wire *wire = &self->setup.plan->wires[index];
    if (wire->trace == NULL ||
        lx_trace_fits(wire->trace, lx_rig_stack(self, index)->trace, error) == 0) {
        return 0;
    }
    return lx_plan_refuse_key(self->setup.plan, "trace", wire->trace_line, error);
}

static int make_engine(struct lx_rig *self, struct lx_error *error)
{
    const struct lx_engine_setup setup = {
        .bus =
            {
                .event = self->setup.event,
                .say = self->setup.say,
                .plan = self->setup.plan,
                .clock = &self->clock,
                .writer = self->writer,
                .silkit = self->silkit,
            },
        .begin = self->begin,
        .ops = &self->ops,
        .wire = check_trace,
        .motion = find_motion,
        .course = lx_rig_find_course,
        .ctx = self,
    };
    return lx_engine_make(&self->engine, &setup, error);
}

static bool make_rig_room(struct lx_rig *self)
{
    const struct dg_plan *plan = self->setup.plan;
    self->shafts = calloc(plan->shaft_count, sizeof *self->shafts);
    self->wires = calloc(plan->wire_count, sizeof *self->wires);
    self->courses = calloc(plan->encoder_count, sizeof(struct lx_courses *));
    return self->shafts != NULL && self->wires != NULL && self->courses != NULL;
}

/* What the engine has made is the rig's. */
static void adopt_parts(struct lx_rig *self)
{
    const struct dg_plan *plan = self->setup.plan;
    self->control = self->engine.control;
    self->control->courses = &dg_course_commands;
    for (size_t i = 0; i < plan->shaft_count; i++) {
        self->shafts[i].control = self->control->shafts[i];
        self->shafts[i].planned = plan->shafts[i].motion;
    }
    for (size_t i = 0; i < plan->wire_count; i++) {
        self->wires[i].rig = self;
        self->wires[i].plan = &plan->wires[i];
        self->wires[i].bus = self->engine.wires[i].bus;
    }
}

/* Once for each wire. @return false without memory */
static bool add_minder(struct lx_rig_shaft *self, struct lx_rig_wire *wire)
{
    const size_t n = self->minder_count;
    if (n > 0 && self->minders[n - 1u] == wire) {
        return true;
    }
    if ((n & (n - 1u)) == 0) { /* full: the capacity is a power of two */
        struct lx_rig_wire **list =
            reallocarray(self->minders, n == 0 ? 1u : 2u * n, sizeof(struct lx_rig_wire *));
        if (list == NULL) {
            return false;
        }
        self->minders = list;
    }
    self->minders[self->minder_count++] = wire;
    return true;
}

/* The shafts of its encoders, and those that drive them, know of a wire that minds. @return false
   without memory */
static bool mind_shafts(struct lx_rig *self, size_t index)
{
    const struct dg_plan *plan = self->setup.plan;
    struct lx_rig_wire *wire = &self->wires[index];
    struct lx_station **stations = self->engine.wires[index].stations;
    bool done = true;
    for (size_t i = 0; wire->bus->ops->turns != NULL && i < wire->plan->encoder_count; i++) {
        for (int at = (int)stations[i]->plan->shaft; at >= 0; at = plan->shafts[at].driver) {
            done = done && add_minder(&self->shafts[at], wire);
        }
    }
    return done;
}

/* @return LX_RIG_OK or what it is that cannot be */
static enum lx_rig_result make_rig(struct lx_rig *self, struct lx_error *error)
{
    bool done = true;
    self->ops = lx_rig_ops;
    self->ops.find = dg_engine_ops.find;
    self->result = LX_RIG_PLAN;
    const int made = make_engine(self, error);
    if (made != 0) {
        return made == LX_ENGINE_SCARCE ? LX_RIG_WORLD : self->result;
    }
    adopt_parts(self);
    for (size_t i = 0; done && i < self->setup.plan->wire_count; i++) {
        done = mind_shafts(self, i);
    }
    if (!done) {
        (void)lx_fail(error, "no memory for the wires");
    }
    return done ? LX_RIG_OK : LX_RIG_WORLD;
}

/* --- stalls --- */

static void tell_stall(const struct lx_rig *self, dg_ns by)
{
    if (by == DG_NEVER) {
        lx_note(self->setup.say, "stopped and continued: requests of that time are answered late");
    } else {
        lx_note(self->setup.say, "held up for %llu ms: requests of that time are answered late",
                (unsigned long long)(by / DG_MS(1)));
    }
}

/* Each one is counted; of long ones that follow each other the first one is told. */
static void on_stall(void *ctx, dg_ns by)
{
    struct lx_rig *self = ctx;
    const dg_ns now = lx_now();
    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        self->wires[i].bus->stalls++;
    }
    if (by < STALL_TOLD) {
        return;
    }
    if (self->stalled == 0 || dg_elapsed(now, self->stalled) > STALL_EPISODE) {
        tell_stall(self, by);
    }
    self->stalled = now;
}

static int look_after_loop(struct lx_rig *self, struct lx_error *error)
{
    const int result = lx_stall_open(&self->stall, self->setup.event, on_stall, self);
    return result < 0 ? lx_fail(error, "no signal: %s", strerror(-result)) : 0;
}

/* --- EEPROM files --- */

/* Clients may wait for what was written. */
static void on_written(void *ctx)
{
    const struct lx_rig *self = ctx;
    for (size_t i = 0; i < DG_PLAN_CONTROLS_MAX; i++) {
        lx_server_wake(self->servers[i]);
    }
}

/* --- power --- */

/* Whoever watches a wire sees its first frame, the boot-up of a node, too. */
static int watch_wire(struct lx_rig_wire *self, struct lx_error *error)
{
    if (self->rig->setup.verbose && lx_rig_listen(self, error) != 0) {
        return -1;
    }
    return self->plan->trace == NULL || lx_rig_trace(self, self->plan->trace, error) == 0
               ? 0
               : lx_plan_refuse_key(self->rig->setup.plan, "trace", self->plan->trace_line, error);
}

static int power_wire(struct lx_rig_wire *self, struct lx_error *error)
{
    return watch_wire(self, error) == 0 ? lx_bus_open(self->bus, self->rig->begin, error) : -1;
}

/* --- control plane --- */

/* The files of whoever is served from here on lie in the folder that the plan names; without it in
   the working directory, and a client over TCP names none. */
static void enter(void *ctx, bool tcp)
{
    struct lx_rig *self = ctx;
    self->folder = tcp && self->setup.plan->files == NULL ? &self->no_files : &self->files;
}

static struct lx_server *open_server(struct lx_rig *self, const struct dg_plan_control *at,
                                     struct lx_error *error)
{
    const struct lx_server_setup setup = {
        .event = self->setup.event,
        .say = self->setup.say,
        .rig = self->control,
        .clock = &self->clock,
        .writer = self->writer,
        .enter = enter,
        .settle = lx_rig_settle,
        .ctx = self,
    };
    return lx_server_open(at, &setup, error);
}

/* Another rig of this name may be running: then with a number behind it, the first one that is
   free, so that what dead ones have left behind is used again. Nobody has asked for the control
   plane, so the rig runs without, too. */
static void serve_default(struct lx_rig *self)
{
    char where[LX_SERVER_ADDRESS_MAX];
    char name[64];
    struct lx_error error;
    (void)snprintf(name, sizeof name, "%.40s", self->setup.plan->name);
    for (unsigned i = 2; self->servers[0] == NULL && i <= SAME_NAME_MAX + 1u; i++) {
        if (lx_server_default(name, where, sizeof where, &error) != 0) {
            break;
        }
        self->servers[0] = open_server(self, &(struct dg_plan_control){.where = where}, &error);
        (void)snprintf(name, sizeof name, "%.40s-%u", self->setup.plan->name, i);
    }
    if (self->servers[0] == NULL) {
        lx_note(self->setup.say, "no control plane: %s", lx_error_line(&error).text);
    }
}

static int open_servers(struct lx_rig *self, struct lx_error *error)
{
    const struct dg_plan *plan = self->setup.plan;
    for (size_t i = 0; i < plan->control_count; i++) {
        self->servers[i] = open_server(self, &plan->controls[i], error);
        if (self->servers[i] == NULL) {
            return lx_plan_refuse_key(plan, "control", plan->controls[i].line, error);
        }
    }
    if (plan->control_count == 0) {
        serve_default(self);
    }
    return 0;
}

static void on_faults(void *ctx, dg_ns now)
{
    struct lx_rig *self = ctx;
    (void)now;
    lx_rig_settle(self, lx_clock_now(&self->clock));
}

/* A start that is refused leaves traces of earlier ones as they are. */
static int release_traces(struct lx_rig *self, struct lx_error *error)
{
    int result = 0;
    for (size_t i = 0; result == 0 && i < self->setup.plan->wire_count; i++) {
        result = lx_trace_release(self->wires[i].trace, error);
    }
    self->stands = result == 0;
    return result;
}

/* The working directory may be gone; then clients name no files. */
static int open_files(struct lx_rig *self, struct lx_error *error)
{
    const struct dg_plan *plan = self->setup.plan;
    const char *folder = plan->files == NULL ? "." : plan->files;
    if (lx_folder_open(&self->files, folder, error) == 0 || plan->files == NULL) {
        return 0;
    }
    return lx_plan_refuse_key(plan, "files", plan->files_line, error);
}

static void warn_of_servers(const struct lx_rig *self)
{
    for (size_t i = 0; i < DG_PLAN_CONTROLS_MAX; i++) {
        lx_server_warn(self->servers[i]);
    }
}

static int power_rig(struct lx_rig *self, struct lx_error *error)
{
    if (open_files(self, error) != 0 ||
        lx_timer_make(&self->faults, self->setup.event, on_faults, self, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        if (power_wire(&self->wires[i], error) != 0) {
            return -1;
        }
    }
    if (open_servers(self, error) != 0 || look_after_loop(self, error) != 0 ||
        lx_rig_join(self, error) != 0 || release_traces(self, error) != 0) {
        return -1;
    }
    warn_of_servers(self);
    lx_rig_settle(self, self->begin);
    return 0;
}

/* --- all of it --- */

int lx_rig_open(struct lx_rig **self, const struct lx_rig_setup *setup, dg_ns now,
                struct lx_error *error)
{
    struct lx_rig *rig = calloc(1, sizeof *rig);
    enum lx_rig_result result = LX_RIG_WORLD;
    *self = NULL;
    if (rig == NULL) {
        (void)lx_fail(error, "no memory for a rig");
        return result;
    }
    rig->setup = *setup;
    rig->begin = now;
    rig->files = LX_FOLDER_NONE;
    rig->no_files = LX_FOLDER_NONE;
    rig->clock = (struct lx_clock){.real = now, .virtual_ = now, .permille = 1000};
    rig->writer = lx_nvm_writer_new(setup->event, on_written, rig);
    rig->silkit = lx_silkit_new(setup->event, setup->say, setup->plan->name);
    if (!make_rig_room(rig) || rig->writer == NULL || rig->silkit == NULL) {
        (void)lx_fail(error, "no memory for a rig");
    } else {
        lx_nvm_writer_try(rig->writer, true);
        result = make_rig(rig, error);
    }
    if (result == LX_RIG_OK && power_rig(rig, error) != 0) {
        result = LX_RIG_WORLD;
    }
    if (result == LX_RIG_OK) {
        lx_nvm_writer_try(rig->writer, false);
        *self = rig;
        return result;
    }
    struct lx_error ignored; /* the first error says why */
    (void)lx_rig_close(rig, &ignored);
    return result;
}

int lx_rig_is_stepped(const struct dg_plan *plan, bool *is, struct lx_error *error)
{
    struct lx_silkit *silkit = lx_silkit_new(NULL, NULL, plan->name);
    int result = silkit == NULL ? lx_fail(error, "no memory for a rig") : 0;
    for (size_t i = 0; result == 0 && i < plan->wire_count; i++) {
        if (lx_wire_of(plan->wires[i].kind)->make == lx_silkit_bus_make) {
            result = lx_silkit_add(silkit, plan, &plan->wires[i], error);
        }
    }
    *is = result == 0 && lx_silkit_is_virtual(silkit);
    lx_silkit_free(silkit);
    return result;
}

void lx_rig_end_after(struct lx_rig *self, dg_ns span)
{
    lx_silkit_end_after(self->silkit, span);
}

bool lx_rig_step(struct lx_rig *self)
{
    return lx_silkit_step(self->silkit);
}

bool lx_rig_read(struct lx_rig *self, size_t index, char *text, size_t size)
{
    struct lx_station *station = &self->engine.stations[index];
    return station->bus->ops->read(station->bus, station, text, size);
}

dg_ns lx_rig_readable(const struct lx_rig *self, size_t index)
{
    const struct lx_station *station = &self->engine.stations[index];
    return station->bus->ops->read == NULL ? DG_NEVER : station->ready;
}

const char *lx_rig_address(struct lx_rig *self, const struct lx_station *station)
{
    const int n =
        snprintf(self->address, sizeof self->address, "%s:", station->bus->setup.wire->kind->name);
    station->bus->ops->address(station->bus, station, self->address + n,
                               sizeof self->address - (size_t)n);
    return self->address;
}

/* A ring from the command line is one thing with one address: that of its coupler, without places.
   @return false when nothing is written any more */
static bool announce_ring(struct lx_rig *self)
{
    const struct dg_plan *plan = self->setup.plan;
    char *address = self->address;
    bool written = fputs("ready ", stdout) >= 0;
    for (size_t i = 0; i < plan->encoder_count; i++) {
        written = written && printf("%s%s", i == 0 ? "" : ",", plan->encoders[i].model->name) >= 0;
    }
    (void)lx_rig_address(self, &self->engine.stations[0]);
    address[strcspn(address, "/")] = '\0';
    return written && printf(" %s\n", address) >= 0;
}

static bool announce_encoders(struct lx_rig *self)
{
    const struct dg_plan *plan = self->setup.plan;
    bool written = true;
    for (size_t i = 0; i < plan->encoder_count; i++) {
        const char *name = plan->file == NULL ? "" : plan->encoders[i].name;
        written = written && printf("ready %s %s%s%s\n", plan->encoders[i].model->name,
                                    lx_rig_address(self, &self->engine.stations[i]),
                                    plan->file == NULL ? "" : " ", name) >= 0;
    }
    return written;
}

const struct lx_stack *lx_rig_stack(const struct lx_rig *self, size_t wire)
{
    return lx_stack_of(self->engine.wires[wire].stations[0]->plan->model);
}

bool lx_rig_mixed(const struct lx_rig_wire *self)
{
    struct lx_station **stations = self->bus->setup.stations;
    bool mixed = false;
    for (size_t i = 1; i < self->plan->encoder_count; i++) {
        mixed = mixed || stations[i]->plan->model->stack != stations[0]->plan->model->stack;
    }
    return mixed;
}

const struct dg_words *lx_rig_words(const struct lx_rig_wire *self)
{
    return lx_rig_mixed(self) ? NULL
                              : dg_words_of(lx_rig_stack(self->rig, self->bus->setup.index)->core);
}

int lx_rig_announce(struct lx_rig *self, struct lx_error *error)
{
    const struct dg_plan *plan = self->setup.plan;
    const bool ring = plan->file == NULL && lx_stack_of(plan->encoders[0].model)->is_ring;
    bool written = ring ? announce_ring(self) : announce_encoders(self);
    for (size_t i = 0; i < plan->control_count; i++) {
        written = written && printf("control %s\n", lx_server_address(self->servers[i])) >= 0;
    }
    if (plan->file != NULL) {
        written = written && puts("ready rig") >= 0;
    }
    return fflush(stdout) == 0 && written
               ? 0
               : lx_fail(error, "cannot write the ready line to stdout: %s", strerror(errno));
}

/* The first error is kept. */
static int worst(int before, int now, struct lx_error *error, const struct lx_error *latest)
{
    if (before == 0 && now != 0) {
        *error = *latest;
    }
    return before != 0 ? before : now;
}

static int close_traces(struct lx_rig *self, struct lx_error *error)
{
    struct lx_error latest;
    int result = 0;
    for (size_t i = 0; self->wires != NULL && i < self->setup.plan->wire_count; i++) {
        struct lx_rig_wire *wire = &self->wires[i];
        result = worst(result, lx_trace_close(wire->trace, &latest), error, &latest);
        lx_rig_deaf(wire);
    }
    return result;
}

static int close_shafts(struct lx_rig *self, struct lx_error *error)
{
    const dg_ns now = lx_clock_now(&self->clock);
    struct lx_error latest;
    int result = 0;
    for (size_t i = 0; self->shafts != NULL && i < self->setup.plan->shaft_count; i++) {
        struct lx_rig_shaft *shaft = &self->shafts[i];
        result = worst(result, lx_record_close(shaft->record, now, &latest), error, &latest);
        for (size_t n = 0; n < LX_RIG_MOTIONS; n++) {
            lx_shaft_free(&shaft->motion[n]);
        }
        lx_rig_read_none(shaft);
        free(shaft->text);
        free(shaft->minders);
    }
    return result;
}

int lx_rig_close(struct lx_rig *self, struct lx_error *error)
{
    struct lx_error latest;
    if (self == NULL) {
        return 0;
    }
    for (size_t i = 0; i < DG_PLAN_CONTROLS_MAX; i++) {
        lx_server_close(self->servers[i]);
        self->servers[i] = NULL;
    }
    lx_timer_close(&self->faults);
    lx_stall_close(&self->stall);
    lx_silkit_leave(self->silkit);
    int result = close_traces(self, error);
    result = worst(result, close_shafts(self, &latest), error, &latest);
    lx_rig_close_courses(self);
    lx_engine_close(&self->engine);
    lx_nvm_writer_free(self->writer);
    lx_silkit_free(self->silkit);
    free(self->topics);
    lx_folder_close(&self->files);
    free(self->wires);
    free(self->shafts);
    free(self);
    return result;
}
