/* SPDX-License-Identifier: MIT */
/*
 * Lines of a motion, moment after moment of a grid. A wake-up writes whatever is due by then: the
 * shaft knows where it was.
 */
#define _GNU_SOURCE
#include "record.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "motion_words.h"
#include "timer.h"

#define HEADER "time_s,angle_deg\n"
#define INTERVAL_MIN DG_US(100)
#define INTERVAL_MAX DG_S(3600)
/* Real time; the clock may be stopped, stepped or sped up at any time, and says nothing. */
#define LOOK_AGAIN DG_MS(10)
/* Between two wake-ups: others have their turn, however far behind a recording is. */
#define PAUSE DG_MS(1)
/* Lines of one wake-up, so that a long step of time does not hold up the wires. */
#define LINES_MAX 1000u
/* More than can be written before somebody misses this process: some hundred megabytes. */
#define BEHIND_MAX 10000000u

/* As csv.c reads them: 10^-9 degree, and the largest angle. */
#define PER_DEGREE INT64_C(1000000000)
#define PER_TURN (360 * PER_DEGREE)
#define ANGLE_MAX_DEG INT64_C(6000000000)

struct lx_record {
    FILE *file;
    struct lx_record_setup setup;
    struct lx_timer timer;
    dg_ns begin;
    dg_ns next;  /* moment of the next line, the rig's time */
    bool failed; /* and ended early */
    struct lx_error reason;
    char path[]; /* setup.path's */
};

/* The greatest number of 10^-9 degrees that is not above the angle: the reader rounds up to the
   next angle, which is this one. */
static int64_t nanodegrees(dg_angle angle)
{
    const uint32_t part = (uint32_t)angle;
    const int64_t turns = (angle - (int64_t)part) / DG_TURN;
    return turns * PER_TURN + (int64_t)dg_muldiv(part, (uint64_t)PER_TURN, (uint64_t)DG_TURN);
}

static bool can_be_read_back(dg_angle angle)
{
    const dg_angle most = ANGLE_MAX_DEG / 360 * DG_TURN;
    return angle >= -most && angle <= most;
}

static void end_early(struct lx_record *self, const char *why)
{
    (void)lx_fail(&self->reason, "%s: the recording ends at %" PRIu64 ".%09" PRIu64 " s: %s",
                  self->path, (self->next - self->begin) / DG_S(1),
                  (self->next - self->begin) % DG_S(1), why);
    self->failed = true;
    lx_timer_at(&self->timer, DG_NEVER);
    lx_complain("%s", self->reason.what);
}

static void write_line(struct lx_record *self)
{
    const dg_angle angle = dg_shaft_angle((void *)self->setup.shaft, self->next);
    const dg_ns time = self->next - self->begin;
    if (!can_be_read_back(angle)) {
        end_early(self, "a recording holds up to 6000000000 degrees");
        return;
    }
    const int64_t value = nanodegrees(angle);
    const uint64_t magnitude = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
    errno = 0;
    if (fprintf(self->file, "%" PRIu64 ".%09" PRIu64 ",%s%" PRIu64 ".%09" PRIu64 "\n",
                time / DG_S(1), time % DG_S(1), value < 0 ? "-" : "",
                magnitude / (uint64_t)PER_DEGREE, magnitude % (uint64_t)PER_DEGREE) < 0) {
        end_early(self, strerror(errno));
        return;
    }
    self->next = dg_after(self->next, self->setup.interval);
}

static void write_lines(struct lx_record *self, dg_ns now, uint64_t most)
{
    if (!self->failed && dg_elapsed(now, self->next) / self->setup.interval > BEHIND_MAX) {
        end_early(self, "too many lines at once; use a longer interval or a slower clock");
    }
    for (uint64_t i = 0; i < most && !self->failed && self->next <= now; i++) {
        write_line(self);
    }
}

static void wait_for_next(struct lx_record *self)
{
    if (!self->failed) {
        const dg_ns now = lx_now();
        const dg_ns due = lx_clock_real(self->setup.clock, self->next);
        const dg_ns soon = dg_after(now, PAUSE);
        lx_timer_at(&self->timer, dg_earliest(due > soon ? due : soon, dg_after(now, LOOK_AGAIN)));
    }
}

static void on_time(void *ctx, dg_ns real)
{
    struct lx_record *self = ctx;
    (void)real;
    write_lines(self, lx_clock_now(self->setup.clock), LINES_MAX);
    wait_for_next(self);
}

static void free_record(struct lx_record *self)
{
    lx_timer_close(&self->timer);
    if (self->file != NULL) {
        (void)fclose(self->file);
    }
    free(self);
}

static struct lx_record *make_record(const struct lx_record_setup *setup, dg_ns now)
{
    const size_t size = strlen(setup->path) + 1;
    struct lx_record *self = calloc(1, sizeof *self + size);
    if (self != NULL) {
        self->setup = *setup;
        self->begin = now;
        self->next = now;
        memcpy(self->path, setup->path, size);
        self->setup.path = self->path;
    }
    return self;
}

/* A timer and a file with a header. */
static int open_parts(struct lx_record *self, struct lx_error *error)
{
    const int result = lx_timer_open(&self->timer, self->setup.event, on_time, self);
    if (result < 0) {
        return lx_fail(error, "%s: no timer for a recording: %s", self->path, strerror(-result));
    }
    static const struct lx_file_mark mark = {0, sizeof HEADER - 1u, HEADER};
    const struct lx_file_wanted wanted = {
        .folder = self->setup.folder, .path = self->path, .mark = &mark};
    self->file = lx_file_create(&wanted, NULL, error);
    if (self->file == NULL) {
        return -1;
    }
    return fputs(HEADER, self->file) >= 0
               ? 0
               : lx_fail(error, "%s: cannot write: %s", self->path, strerror(errno));
}

struct lx_record *lx_record_open(const struct lx_record_setup *setup, dg_ns now,
                                 struct lx_error *error)
{
    if (setup->interval < INTERVAL_MIN || setup->interval > INTERVAL_MAX) {
        (void)lx_fail(error,
                      "%s: a recording has a line every 100 us to 1 h, not every %" PRIu64 " ns",
                      setup->path, setup->interval);
        return NULL;
    }
    if (!dg_motion_is_file(setup->path)) {
        (void)lx_fail(error, "%.48s: the name of a recording ends in .csv", setup->path);
        return NULL;
    }
    struct lx_record *self = make_record(setup, now);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory for a recording", setup->path);
        return NULL;
    }
    if (open_parts(self, error) != 0) {
        free_record(self);
        return NULL;
    }
    write_lines(self, now, 1);
    wait_for_next(self);
    return self;
}

void lx_record_write(struct lx_record *self, dg_ns now)
{
    if (self != NULL) {
        write_lines(self, now, UINT64_MAX);
    }
}

int lx_record_close(struct lx_record *self, dg_ns now, struct lx_error *error)
{
    if (self == NULL) {
        return 0;
    }
    write_lines(self, now, UINT64_MAX);
    if (fclose(self->file) != 0 && !self->failed) {
        self->failed = true;
        (void)lx_fail(&self->reason, "%s: cannot write: %s", self->path, strerror(errno));
    }
    self->file = NULL;
    const int result = self->failed ? lx_fail(error, "%s", self->reason.what) : 0;
    free_record(self);
    return result;
}
