/* SPDX-License-Identifier: MIT */
/*
 * The life of a participant:
 *
 *   add() of each wire ... join() ... ports ... start() --ready--> step, step, ... --> free()
 *
 * Everything here is called by the loop, but for the handlers below "on the library's threads",
 * which put what they were told into the inbox and return, and for make_participant(), for which
 * the loop waits (silkit_wait.c). The library is let do its work in between: a step is completed
 * by the loop when all of it is done.
 */
#define _GNU_SOURCE
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "silkit_parts.h"

/* Errors of the library are said by its functions; its own log is not wanted. */
#define CONFIGURATION "{\"Logging\":{\"Sinks\":[]}%s%s}"
/* Others meet a participant at ports of its own, which the library opens on all interfaces: who has
   a registry on loopback has others there, too. */
#define PORTS                                                                                      \
    ",\"Middleware\":{\"AcceptorUris\":["                                                          \
    "\"local:///tmp/%s-%ld-%" PRIu64 ".silkit\",\"tcp://127.0.0.1:0\"]}"
#define PORTS_MAX 192u
/* One write for all that a step sends to somebody, in place of one for each frame; who receives it
   need not know. The library does so only with virtual time. */
#define TOGETHER ",\"Experimental\":{\"TimeSynchronization\":{\"EnableMessageAggregation\":\"On\"}}"
#define CONFIGURATION_MAX 384u
/* The name that a registry has among participants. */
#define REGISTRY "SilKitRegistry"
/* Who has left may have let time go on before, up to the step after the next. */
#define GRACE 3u
/* Without a step for so long, after somebody has left without a word, time stands still for good.
 */
#define STANDSTILL_US 5000000u
/* Real times are nanoseconds since 1970, or none at all, -2^63; no simulation lasts ten years. */
#define REAL_MIN DG_S(315360000)
/* Others may be asked to end as well; a simulation that hangs does not hold up the end of a rig. */
#define END_MS 2000u

/* --- on the library's threads --- */

static void post_message(struct lx_silkit *self, enum lx_silkit_kind kind, uint64_t time)
{
    const struct lx_silkit_message message = {.kind = kind, .time = time};
    lx_silkit_inbox_put(&self->inbox, &message, NULL, 0);
}

/* A controller is to be started here: then nobody can send before all can receive. */
static void on_lifecycle_ready(void *ctx, struct lx_sk_lifecycle *lifecycle)
{
    struct lx_silkit *self = ctx;
    (void)lifecycle;
    for (size_t i = 0; i < self->count; i++) {
        if (self->port[i]->can != NULL) {
            (void)self->lib.can_start(self->port[i]->can);
        }
    }
    post_message(self, LX_SILKIT_READY, 0);
}

static void on_stop(void *ctx, struct lx_sk_lifecycle *lifecycle)
{
    (void)lifecycle;
    post_message(ctx, LX_SILKIT_STOPPED, 0);
}

static void on_shutdown(void *ctx, struct lx_sk_lifecycle *lifecycle)
{
    (void)lifecycle;
    post_message(ctx, LX_SILKIT_SHUTDOWN, 0);
}

static void on_abort(void *ctx, struct lx_sk_lifecycle *lifecycle, int16_t before)
{
    (void)lifecycle;
    (void)before;
    post_message(ctx, LX_SILKIT_ABORTED, 0);
}

static void on_step(void *ctx, struct lx_sk_time *clock, uint64_t now, uint64_t duration)
{
    (void)clock;
    (void)duration;
    post_message(ctx, LX_SILKIT_STEP, now);
}

static void on_peer_gone(void *ctx, struct lx_sk_monitor *monitor,
                         const struct lx_sk_connection *peer)
{
    struct lx_silkit *self = ctx;
    const struct lx_silkit_message message = {.kind = LX_SILKIT_GONE};
    (void)monitor;
    lx_silkit_inbox_put(&self->inbox, &message, peer->name, strlen(peer->name) + 1u);
}

/* --- what the library refuses --- */

int lx_silkit_refused(const struct lx_silkit *self, const char *what, struct lx_error *error)
{
    return lx_fail(error, "SIL Kit: %s: %s", what, self->lib.last_error());
}

void lx_silkit_complain(struct lx_silkit *self, const char *what)
{
    if (!self->complained) {
        self->complained = true;
        lx_complain("SIL Kit: %s: %s", what, self->lib.last_error());
    }
}

void lx_silkit_mask(sigset_t *before)
{
    sigset_t all;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, before);
}

void lx_silkit_unmask(const sigset_t *before)
{
    (void)pthread_sigmask(SIG_SETMASK, before, NULL);
}

/* --- time --- */

dg_ns lx_silkit_moment_of(const struct lx_silkit *self, uint64_t time)
{
    const uint64_t since = time > self->origin ? time - self->origin : 0;
    const dg_ns at = dg_after(self->begin, since);
    return at > lx_now() ? at : lx_now();
}

uint64_t lx_silkit_time_at(const struct lx_silkit *self, dg_ns now)
{
    return self->origin + dg_elapsed(now, self->begin);
}

static void begin_step(struct lx_silkit *self, uint64_t at)
{
    if (!self->begun) {
        self->begun = true;
        self->origin = at;
        self->begin = lx_now();
    }
    if (self->grace > 0 && --self->grace == 0) {
        self->standstill = sd_event_source_disable_unref(self->standstill);
    }
    self->stepping = true;
    self->at = at;
    lx_silkit_sort(&self->pending);
    lx_silkit_lanes_begin(self);
}

static void step_ports(struct lx_silkit *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        if (self->port[i]->step != NULL) {
            self->port[i]->step(self->port[i]->ctx, now);
        }
    }
}

/* In real time there are no steps, but what is said in each is said as often. */
static void on_tick(void *ctx, dg_ns now)
{
    struct lx_silkit *self = ctx;
    step_ports(self, now);
    lx_timer_at(&self->tick, dg_after(now, DG_US(self->settings.step_us)));
}

static void say_ready(struct lx_silkit *self)
{
    if (self->ready) {
        return;
    }
    self->ready = true;
    for (size_t i = 0; i < self->count; i++) {
        if (self->port[i]->ready != NULL) {
            self->port[i]->ready(self->port[i]->ctx, lx_now());
        }
    }
}

static void end_step(struct lx_silkit *self)
{
    step_ports(self, lx_now());
    self->stepping = false;
    if (self->lib.complete(self->clock) != 0) {
        lx_silkit_complain(self, "a step cannot be completed");
    }
}

/* --- what came --- */

static void give_up(struct lx_silkit *self, const char *what)
{
    if (!self->ended) {
        self->ended = true;
        lx_complain("SIL Kit: %s", what);
        (void)sd_event_exit(self->event, EXIT_FAILURE);
    }
}

static void end_simulation(struct lx_silkit *self, enum lx_silkit_kind kind)
{
    if (self->ended) {
        return;
    }
    if (kind == LX_SILKIT_ABORTED) {
        give_up(self, "the simulation was aborted");
        return;
    }
    self->ended = true;
    lx_note(self->say, "SIL Kit: the simulation has ended");
    (void)sd_event_exit(self->event, EXIT_SUCCESS);
}

static int on_standstill(sd_event_source *source, uint64_t usec, void *ctx)
{
    struct lx_silkit *self = ctx;
    (void)usec;
    if (!self->stepping) {
        give_up(self, "no participant advances the time any more");
        return 0;
    }
    (void)sd_event_source_set_time_relative(source, STANDSTILL_US);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

static void note_gone(struct lx_silkit *self, const char *name)
{
    const bool coordinated = self->settings.time == DG_PLAN_COORDINATED;
    if (strcmp(name, REGISTRY) != 0) {
        lx_note(self->say, "SIL Kit: %s has left the simulation", name);
    } else if (coordinated && !self->heard) {
        give_up(self, "the registry has gone before the simulation has begun");
    } else {
        lx_note(self->say,
                "SIL Kit: the registry has gone; present participants continue, no other "
                "can join");
    }
    if (coordinated && self->begun && self->standstill == NULL) {
        self->grace = GRACE;
        (void)sd_event_add_time_relative(self->event, &self->standstill, CLOCK_MONOTONIC,
                                         STANDSTILL_US, 0, on_standstill, self);
    }
}

/* Who has virtual time is told what has none as if it were sent now. */
static void note_time(struct lx_silkit *self, const struct lx_silkit_message *message)
{
    const bool sent = message->kind == LX_SILKIT_FRAME || message->kind == LX_SILKIT_DATA;
    if (sent && self->clock == NULL && message->time < REAL_MIN) {
        self->mixed = true;
    }
}

static void sort_out(struct lx_silkit *self, const struct lx_silkit_message *message)
{
    switch (message->kind) {
    case LX_SILKIT_READY:
        self->heard = true;
        if (self->clock == NULL) {
            say_ready(self);
            on_tick(self, lx_now());
        }
        break;
    case LX_SILKIT_STEP:
        begin_step(self, message->time);
        break;
    case LX_SILKIT_GONE:
        note_gone(self, (const char *)lx_silkit_bytes(message));
        break;
    case LX_SILKIT_ABORTED:
    case LX_SILKIT_STOPPED:
    case LX_SILKIT_SHUTDOWN:
        self->stopped = true;
        end_simulation(self, message->kind);
        break;
    case LX_SILKIT_FRAME:
    case LX_SILKIT_DATA:
    case LX_SILKIT_REFUSED:
    case LX_SILKIT_LOST:
    case LX_SILKIT_STATE:
        note_time(self, message);
        if (lx_silkit_list_add(&self->pending, message)) {
            return; /* its bytes are the list's now */
        }
        self->lost++;
        break;
    }
    free(message->bytes);
}

static void take_messages(struct lx_silkit *self)
{
    const uint64_t lost = lx_silkit_inbox_take(&self->inbox, &self->came);
    if (lost > self->lost) {
        lx_complain("SIL Kit: %llu messages are lost, because more came than the rig handled",
                    (unsigned long long)(lost - self->lost));
        self->lost = lost;
    }
    for (size_t i = 0; i < self->came.count; i++) {
        sort_out(self, &self->came.at[i]);
    }
    self->came.count = 0;
}

static int on_wake(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_silkit *self = ctx;
    uint64_t count = 0;
    (void)source;
    (void)events;
    (void)!read(fd, &count, sizeof count);
    take_messages(self);
    while (self->clock == NULL && self->pending.first < self->pending.count) {
        lx_silkit_deliver(self, &self->pending, lx_now(), UINT64_MAX);
    }
    if (self->clock == NULL) {
        lx_silkit_list_trim(&self->pending);
    }
    return 0;
}

/* Of somebody whose clock is not ours: there is no moment for it but now. */
static bool is_message_ahead(const struct lx_silkit *self, const struct lx_silkit_message *message)
{
    return message->time > self->at;
}

/* What is left is of this very moment, which is for the next step, and behind it what is foreign. */
static void deliver_foreign(struct lx_silkit *self)
{
    struct lx_silkit_list *list = &self->pending;
    const size_t first = list->first;
    while (list->first < list->count && !is_message_ahead(self, &list->at[list->first])) {
        list->first++;
    }
    const size_t foreign = list->first;
    while (list->first < list->count) {
        lx_silkit_deliver(self, list, lx_now(), UINT64_MAX);
    }
    list->first = first;
    list->count = foreign;
    lx_silkit_list_trim(list);
}

/* Let time go on to the next deadline up to `at`. What lanes have to do before it comes first; at
   one moment deadlines come before messages, and theirs, of times before `end`, before others. */
static bool pass_step(struct lx_silkit *self, dg_ns at, uint64_t end)
{
    const dg_ns next = lx_strand_next(NULL);
    if (next <= at) {
        lx_silkit_lanes_run(self, next, lx_silkit_time_at(self, next));
    } else {
        lx_silkit_lanes_run(self, at, end);
    }
    return lx_time_pass(at);
}

/* Sorted, so those that are due stand first, and those without a moment last. */
bool lx_silkit_step(struct lx_silkit *self)
{
    if (!self->stepping) {
        return false;
    }
    if (self->span != 0 && self->at - self->origin > self->span) {
        (void)sd_event_exit(self->event, EXIT_SUCCESS);
        return true;
    }
    say_ready(self);
    struct lx_silkit_list *list = &self->pending;
    const struct lx_silkit_message *next =
        list->first < list->count ? &list->at[list->first] : NULL;
    if (next != NULL && next->time < self->at) {
        const dg_ns at = lx_silkit_moment_of(self, next->time);
        if (!pass_step(self, at, next->time + 1u)) {
            lx_silkit_deliver(self, list, at, self->at);
        }
        return true;
    }
    if (pass_step(self, lx_silkit_moment_of(self, self->at), self->at)) {
        return true;
    }
    deliver_foreign(self);
    end_step(self);
    return true;
}

/* --- life --- */

struct lx_silkit *lx_silkit_new(sd_event *event, const struct lx_say *say, const char *name)
{
    struct lx_silkit *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->event = event;
        self->say = say;
        self->rig = name;
        self->inbox.wakes = -1;
        self->threads = 1;
    }
    return self;
}

bool lx_silkit_has_joined(const struct lx_silkit *self)
{
    return self->participant != NULL;
}

bool lx_silkit_is_ready(const struct lx_silkit *self)
{
    return self->ready;
}

bool lx_silkit_has_mixed_time(const struct lx_silkit *self)
{
    return self->mixed;
}

void lx_silkit_end_after(struct lx_silkit *self, dg_ns span)
{
    self->span = span;
}

static int open_inbox(struct lx_silkit *self, struct lx_error *error)
{
    int result = lx_silkit_inbox_open(&self->inbox);
    if (result >= 0) {
        result = sd_event_add_io(self->event, &self->io, self->inbox.wakes, EPOLLIN, on_wake, self);
    }
    return result < 0 ? lx_fail(error, "no way to wake the loop: %s", strerror(-result)) : 0;
}

static int make_clock(struct lx_silkit *self, struct lx_error *error)
{
    const uint64_t step = DG_US(self->settings.step_us);
    if (!lx_silkit_is_virtual(self)) {
        return lx_timer_make(&self->tick, self->event, on_tick, self, error);
    }
    return self->lib.time_new(&self->clock, self->lifecycle) != 0 ||
                   self->lib.on_step(self->clock, self, on_step, step) != 0
               ? lx_silkit_refused(self, "no virtual time", error)
               : 0;
}

static int make_life(struct lx_silkit *self, struct lx_error *error)
{
    const bool coordinated = self->settings.time == DG_PLAN_COORDINATED;
    const struct lx_sk_lifecycle_setup setup = {
        .header = {.version = LX_SK_LIFECYCLE},
        .mode = coordinated ? LX_SK_COORDINATED : LX_SK_AUTONOMOUS,
    };
    struct lx_sk_monitor *monitor = NULL;
    if (self->lib.lifecycle_new(&self->lifecycle, self->participant, &setup) != 0 ||
        self->lib.on_ready(self->lifecycle, self, on_lifecycle_ready) != 0 ||
        self->lib.on_stop(self->lifecycle, self, on_stop) != 0 ||
        self->lib.on_shutdown(self->lifecycle, self, on_shutdown) != 0 ||
        self->lib.on_abort(self->lifecycle, self, on_abort) != 0 ||
        self->lib.monitor_new(&monitor, self->participant) != 0 ||
        self->lib.on_peer_gone(monitor, self, on_peer_gone) != 0) {
        return lx_silkit_refused(self, "no lifecycle", error);
    }
    return make_clock(self, error);
}

/* The library says it in its own words, some of them long; who has the name already is what happens
   most. */
static int refuse_to_join(const struct lx_silkit *self, struct lx_error *error)
{
    const char *why = self->lib.last_error();
    if (strstr(why, "already exists") != NULL) {
        struct lx_words right = {""};
        lx_words_add(&right, "expected %s,%s,PARTICIPANT with another name", self->where.uri,
                     self->where.network);
        return lx_refuse(error, right.text, "SIL Kit: there is a participant %s already",
                         lx_silkit_name(self));
    }
    return lx_refuse(error, "start a registry there, e.g. sil-kit-registry", "SIL Kit: %s", why);
}

static void write_configuration(const struct lx_silkit *self, char to[CONFIGURATION_MAX])
{
    const bool together = self->settings.aggregate && lx_silkit_is_virtual(self);
    char ports[PORTS_MAX] = "";
    if (lx_silkit_is_loopback(&self->where)) {
        (void)snprintf(ports, sizeof ports, PORTS, lx_silkit_name(self), (long)getpid(),
                       (uint64_t)lx_now());
    }
    (void)snprintf(to, CONFIGURATION_MAX, CONFIGURATION, ports, together ? TOGETHER : "");
}

static void warn_beyond_loopback(const struct lx_silkit *self)
{
    if (!lx_silkit_is_loopback(&self->where)) {
        lx_complain("%s: beyond loopback; every machine that reaches the ports of %s can turn its "
                    "shafts and is on its wires",
                    self->where.uri, lx_silkit_name(self));
    }
}

static int make_participant(struct lx_silkit_call *call, struct lx_error *error)
{
    struct lx_silkit *self = call->all;
    struct lx_sk_config *config = NULL;
    char text[CONFIGURATION_MAX];
    write_configuration(self, text);
    if (self->lib.config_new(&config, text) != 0) {
        return lx_silkit_refused(self, "no configuration", error);
    }
    const int32_t code =
        self->lib.join(&self->participant, config, lx_silkit_name(self), self->where.uri);
    if (code != 0) {
        self->participant = NULL;
        (void)refuse_to_join(self, error);
    }
    (void)self->lib.config_free(config);
    return code != 0 ? -1 : make_life(self, error);
}

int lx_silkit_join(struct lx_silkit *self, const char *where, struct lx_silkit_where *out,
                   struct lx_error *error)
{
    struct lx_silkit_call call = {.make = make_participant, .all = self};
    const int result = lx_silkit_split(where, out, error);
    if (result != 0 || self->participant != NULL) {
        return result;
    }
    if (lx_silkit_load(&self->lib, error) != 0 || open_inbox(self, error) != 0) {
        return -1;
    }
    (void)snprintf(call.name, sizeof call.name, "%s", lx_silkit_name(self));
    if (lx_silkit_wait(&call, error) != 0) {
        return -1;
    }
    warn_beyond_loopback(self);
    return 0;
}

int lx_silkit_start(struct lx_silkit *self, struct lx_error *error)
{
    sigset_t before;
    if (lx_silkit_lanes_open(self, error) != 0) {
        return -1;
    }
    lx_silkit_mask(&before);
    const int32_t code = self->lib.start(self->lifecycle);
    lx_silkit_unmask(&before);
    return code == 0 ? 0 : lx_silkit_refused(self, "it does not start", error);
}

/* A step that waits for us is completed first: the library's thread is in it. */
void lx_silkit_leave(struct lx_silkit *self)
{
    int16_t state = 0;
    if (self == NULL || self->participant == NULL) {
        return;
    }
    if (lx_silkit_is_left_behind()) {
        self->participant = NULL;
        return;
    }
    if (self->stepping) {
        (void)self->lib.complete(self->clock);
    }
    if (self->heard &&
        (self->stopped || self->lib.stop(self->lifecycle, "the rig was ended") == 0)) {
        if (lx_silkit_inbox_wait(&self->inbox, END_MS)) {
            (void)self->lib.over(self->lifecycle, &state); /* what is left is to tell others */
        }
    }
    (void)self->lib.leave(self->participant);
    self->participant = NULL;
}

void lx_silkit_free(struct lx_silkit *self)
{
    if (self == NULL) {
        return;
    }
    lx_silkit_leave(self);
    lx_silkit_lanes_end(self);
    lx_silkit_lanes_free(self);
    self->standstill = sd_event_source_disable_unref(self->standstill);
    lx_timer_close(&self->tick);
    self->io = sd_event_source_disable_unref(self->io);
    if (lx_silkit_is_left_behind()) {
        return; /* a thread may look at it still */
    }
    lx_silkit_inbox_close(&self->inbox);
    lx_silkit_list_free(&self->came);
    lx_silkit_list_free(&self->pending);
    free(self->port);
    free(self);
}
