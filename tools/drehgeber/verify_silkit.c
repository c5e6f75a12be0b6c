/* SPDX-License-Identifier: MIT */
/*
 * A participant as a rig is one, but on the other end of the wire. In virtual time a step that has begun is
 * not over while the command thinks: time goes on in run_until() only.
 *
 *   others       ..answer..|
 *   run_until()            |-> answer, return           |-> complete the step
 *   the command            |              judge it, send|
 *                          T
 */
#define _GNU_SOURCE
#include "verify_silkit.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <systemd/sd-event.h>

#include "can.h"
#include "ending.h"
#include "silkit.h"
#include "timer.h"

/* What others have to require, when it is not given. */
#define NAME "verify"
/* Bit rate of the encoders, for a network simulator. */
#define KBAUD 250u
/* How long others may take to begin, in real time. */
#define BEGINNING_MAX_S 10u
/* A signal that ends the command is seen so soon. */
#define LOOK_US 50000u
/* Room for what comes while nobody looks; the rest is lost, as with a socket. */
#define CAME_MAX 65536u

struct verify_silkit {
    sd_event *event;
    struct lx_silkit *silkit;
    struct lx_timer limit;         /* of run_until() */
    bool due;                      /* it is over */
    struct lx_can *can;            /* owned; NULL: it is a line, with */
    struct lx_silkit_port request; /* ... what goes to the encoder, */
    struct lx_silkit_port reply;   /* ... and what comes */
    uint8_t came[CAME_MAX];
    size_t count; /* of bytes that came */
};

bool verify_silkit_is(const struct options *options)
{
    return strcmp(options->wire->name, "silkit") == 0;
}

/* --- what comes --- */

static void keep_bytes(struct verify_silkit *self, const void *bytes, size_t n)
{
    if (n <= sizeof self->came - self->count) {
        memcpy(self->came + self->count, bytes, n);
        self->count += n;
    }
}

static void on_frame(void *ctx, dg_ns now, const struct dg_can_frame *frame)
{
    (void)now;
    keep_bytes(ctx, frame, sizeof *frame);
}

static void on_characters(void *ctx, dg_ns now, const struct lx_silkit_message *message, bool last)
{
    (void)now;
    (void)last;
    keep_bytes(ctx, lx_silkit_bytes(message), message->length);
}

/* Frames with 29 bits, states of the controller, deadlines of encoders: nothing of that is asked for. */
static void ignore_foreign(void *ctx, uint32_t bits)
{
    (void)ctx;
    (void)bits;
}

static void ignore_bus(void *ctx, dg_ns now, enum dg_host_bus event)
{
    (void)ctx;
    (void)now;
    (void)event;
}

static void ignore_settled(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
}

/* --- time --- */

static void on_limit(void *ctx, dg_ns now)
{
    struct verify_silkit *self = ctx;
    (void)now;
    self->due = true;
}

static void hold_signals(sigset_t *before)
{
    sigset_t ending;
    lx_ending_signals(&ending);
    (void)sigprocmask(SIG_BLOCK, &ending, before);
}

static bool is_over(const struct verify_silkit *self)
{
    return sd_event_get_state(self->event) == SD_EVENT_FINISHED || lx_ending_asked();
}

static void serve_events(const struct verify_silkit *self)
{
    while (!is_over(self) && sd_event_run(self->event, 0) > 0) {
    }
}

/* One thing of the present step, or a little while in which others are at work. */
static void pass_time(const struct verify_silkit *self)
{
    serve_events(self);
    if (!is_over(self) && !lx_silkit_step(self->silkit)) {
        (void)sd_event_run(self->event, LOOK_US);
    }
}

/* Until then, or until something has come if that `ends` it. In virtual time the limit is met within a step,
   and something comes in one. A signal ends the command, but not without a word to the others. */
static void run_until(struct verify_silkit *self, dg_ns until, bool ends)
{
    sigset_t before;
    hold_signals(&before);
    serve_events(self);
    self->due = false;
    lx_timer_at(&self->limit, until);
    while (!self->due && !(ends && self->count > 0) && !is_over(self)) {
        pass_time(self);
    }
    lx_timer_at(&self->limit, DG_NEVER);
    if (lx_ending_asked()) {
        lx_silkit_leave(self->silkit);
    }
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
}

/* --- sending and receiving --- */

static bool is_gone(const struct verify_silkit *self)
{
    return !lx_silkit_has_joined(self->silkit) || lx_silkit_has_mixed_time(self->silkit) ||
           sd_event_get_state(self->event) == SD_EVENT_FINISHED;
}

int verify_silkit_send(struct verify_silkit *self, const void *bytes, size_t n)
{
    if (is_gone(self)) {
        return -1;
    }
    if (self->can != NULL) {
        lx_can_send(self->can, bytes);
    } else {
        lx_silkit_publish(&self->request, bytes, n);
    }
    return 0;
}

long verify_silkit_receive(struct verify_silkit *self, dg_ns until, void *to, size_t size)
{
    if (self->count == 0) {
        run_until(self, until, true);
    }
    if (self->count == 0 || is_gone(self)) {
        return is_gone(self) ? -1 : 0;
    }
    const size_t n = size < self->count ? size : self->count;
    memcpy(to, self->came, n);
    self->count -= n;
    memmove(self->came, self->came + n, self->count);
    return (long)n;
}

void verify_silkit_wait(struct verify_silkit *self, dg_ns until)
{
    run_until(self, until, false);
}

bool verify_silkit_explain(const struct verify_silkit *self, struct lx_error *error)
{
    if (!lx_silkit_has_mixed_time(self->silkit)) {
        return false;
    }
    (void)lx_refuse(error, "expected the --set time=... of the encoder",
                    "SIL Kit: %s has real time, and others have virtual time",
                    lx_silkit_name(self->silkit));
    return true;
}

/* --- joining --- */

static int open_frames(struct verify_silkit *self, const char *where, struct lx_error *error)
{
    const struct lx_can_setup setup = {
        .event = self->event,
        .silkit = self->silkit,
        .where = where,
        .rx = on_frame,
        .foreign = ignore_foreign,
        .bus = ignore_bus,
        .settle = ignore_settled,
        .ctx = self,
    };
    self->can = lx_silkit_can_open(&setup, error);
    if (self->can == NULL) {
        return -1;
    }
    self->can->ops->expect(self->can, KBAUD);
    return 0;
}

static int open_topics(struct verify_silkit *self, const char *where, struct lx_error *error)
{
    struct lx_silkit_where parts;
    if (lx_silkit_join(self->silkit, where, &parts, error) != 0) {
        return -1;
    }
    self->request = (struct lx_silkit_port){.ctx = self};
    self->reply = (struct lx_silkit_port){
        .length_max = LX_SILKIT_CHARACTERS_MAX, .receive = on_characters, .ctx = self};
    lx_silkit_name_topic(&self->request, parts.network, "request");
    lx_silkit_name_topic(&self->reply, parts.network, "reply");
    return lx_silkit_subscribe(self->silkit, &self->reply, LX_SILKIT_CHARACTERS, error) != 0
               ? -1
               : lx_silkit_offer(self->silkit, &self->request, LX_SILKIT_CHARACTERS, error);
}

/* The wire is that of a plan, as `run` makes it of the same options. */
static int add_wire(struct verify_silkit *self, const struct options *options,
                    struct lx_error *error)
{
    struct dg_plan plan;
    if (options_plan(options, &plan, error) != 0) {
        return -1;
    }
    self->silkit = lx_silkit_new(self->event, &options->say, NAME);
    const int result = self->silkit == NULL
                           ? lx_fail(error, "no memory for a simulation")
                           : lx_silkit_add(self->silkit, &plan, &plan.wires[0], error);
    lx_plan_free(&plan);
    return result;
}

static int join_simulation(struct verify_silkit *self, const struct options *options,
                           struct lx_error *error)
{
    const bool frames = options->device->stack->medium == DG_MEDIUM_FRAMES;
    if (sd_event_new(&self->event) < 0) {
        return lx_fail(error, "no event loop");
    }
    if (add_wire(self, options, error) != 0) {
        return -1;
    }
    if (lx_silkit_is_virtual(self->silkit)) {
        lx_time_own();
    }
    return lx_timer_make(&self->limit, self->event, on_limit, self, error) != 0 ||
                   (frames ? open_frames : open_topics)(self, options->where, error) != 0
               ? -1
               : lx_silkit_start(self->silkit, error);
}

static int await_beginning(struct verify_silkit *self, struct lx_error *error)
{
    const dg_ns end = lx_real_now() + DG_S(BEGINNING_MAX_S);
    struct lx_words right = {""};
    lx_timer_at(&self->limit, lx_now());
    while (!is_over(self) && lx_real_now() < end) {
        if (self->due && lx_silkit_is_ready(self->silkit)) {
            return 0;
        }
        pass_time(self);
    }
    if (is_over(self)) {
        return lx_fail(error, "SIL Kit: the simulation ended before it has begun");
    }
    lx_words_add(&right,
                 "expected a system controller that requires %s and the encoder's participant, or "
                 "--set time=autonomous or time=real, as the encoder has it",
                 lx_silkit_name(self->silkit));
    return lx_refuse(error, right.text, "SIL Kit: the simulation has not begun after %u s",
                     BEGINNING_MAX_S);
}

struct verify_silkit *verify_silkit_open(const struct options *options, struct lx_error *error)
{
    struct verify_silkit *self = lx_allocate(sizeof *self, "a simulation", error);
    sigset_t before;
    if (self == NULL) {
        return NULL;
    }
    hold_signals(&before);
    if (join_simulation(self, options, error) != 0 || await_beginning(self, error) != 0) {
        verify_silkit_close(self);
        self = NULL;
    }
    (void)sigprocmask(SIG_SETMASK, &before, NULL); /* here a signal that came ends the command */
    return self;
}

void verify_silkit_close(struct verify_silkit *self)
{
    if (self == NULL) {
        return;
    }
    lx_silkit_leave(self->silkit);
    lx_can_close(self->can);
    lx_timer_close(&self->limit);
    lx_silkit_free(self->silkit);
    self->event = sd_event_unref(self->event);
    if (!lx_silkit_is_left_behind()) {
        free(self); /* else a thread may look at its ports still */
    }
}
