/* SPDX-License-Identifier: MIT */
/*
 *   clock edges -- on_edges --> edge() --\
 *                                        > answer_edge(): data, deadline
 *   timer ------- on_timeout -> step() --/
 *
 * Nothing is printed between an edge and its answer, nor inside a frame that goes well: a line on
 * stderr costs more than an edge.
 */
#include "gpio.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>

/* Edges taken at once, and how often in a row before others have their turn. */
#define BATCH 64u
#define BATCHES_MAX 32u
/* How long an edge may be on its way to the queue when the line already has its level. */
#define SETTLE DG_MS(1)
#define WATCH DG_S(1)
/* Trouble after a longer time without is told anew. */
#define EPISODE DG_S(10)
/* Room for what a rate is good for. */
#define GOOD_FOR_MAX 96u

/* What is known of the rate is told after so many frames. */
static const uint64_t tell_after[] = {5, 100, LX_GPIO_RATE_ENOUGH};
#define TELL_COUNT DG_COUNT(tell_after)

static void close_gone_lines(struct lx_gpio *self, int reason)
{
    if (self->has_gone) {
        return;
    }
    self->has_gone = true;
    lx_complain("%s: gone (%s); looking for it until it is back", self->setup.name,
                strerror(-reason));
    self->setup.gone(self->setup.ctx);
}

static dg_ns deadline_of(const struct lx_gpio *self)
{
    return dg_bus_next(self->setup.line->bus);
}

/* Answers have half a period: the master may look at the line at the edge behind a rising one
 * already.
 */
static void judge_edge(struct lx_gpio *self, dg_ns next)
{
    if (self->due) {
        self->counters.late += self->waiting > 0 || next < self->answered;
    }
    self->due = false;
}

static void take_kernel_edge(struct lx_gpio *self, const struct lx_gpio_edge *edge)
{
    const struct lx_clocked *line = self->setup.line;

    self->doubtful = false;
    self->counters.edges++;
    self->counters.lost += edge->gap || edge->level == dg_bus_edges_clock(line->bus);
    judge_edge(self, edge->at);
    (void)dg_bus_edge(line->bus, edge->at, edge->level);
    if (!edge->level) {
        return;
    }
    if (self->waiting == 0) {
        self->asked = edge->at;
    }
    self->waiting++;
    self->due = true;
}

/* The data line as the encoder has it. It is written after every rising edge, whether it changes or
   not, so that all answers take the same time. */
static void answer_edge(struct lx_gpio *self)
{
    struct lx_gpio_lines *lines = self->setup.lines;
    const struct lx_clocked *line = self->setup.line;
    const bool level = line->data;

    if (self->waiting > 0 || level != self->data) {
        const int result = lines->ops->set_output(lines, level);
        if (result < 0) {
            close_gone_lines(self, result);
            return;
        }
        self->data = level;
    }
    if (self->waiting > 0) {
        self->answered = lx_now();
        lx_gpio_rate_take(&self->rate, dg_elapsed(self->answered, self->asked), self->waiting);
        self->waiting = 0;
    }
    /* A timer that fires early asks again: cheaper than moving it with every edge. */
    const dg_ns deadline = deadline_of(self);
    if (!self->doubtful && self->timeout.at > deadline) {
        lx_timer_at(&self->timeout, deadline);
    }
}

/* What is queued now, up to `batches`. @return 0 or a negative errno */
static int take_edges(struct lx_gpio *self, unsigned batches)
{
    struct lx_gpio_lines *lines = self->setup.lines;
    struct lx_gpio_edge edges[BATCH];
    int n = 1;

    lx_clocked_listen(self->setup.line);
    for (unsigned i = 0; i < batches && n > 0; i++) {
        n = lines->ops->read(lines, edges, BATCH);
        for (int j = 0; j < n; j++) {
            take_kernel_edge(self, &edges[j]);
        }
    }
    return n < 0 ? n : 0;
}

static int on_edges(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_gpio *self = ctx;
    const int result = (events & EPOLLIN) != 0 ? take_edges(self, 1) : -ENODEV;
    (void)source;
    (void)fd;
    if (result < 0) {
        close_gone_lines(self, result);
        return 0;
    }
    answer_edge(self);
    return 0;
}

/* Whether the clock has the level of its last edge, so that the timeout may end. When not, an edge
   is on its way or has been lost: it is waited for once, and made up for then. */
static bool settle_clock(struct lx_gpio *self, dg_ns now)
{
    struct lx_gpio_lines *lines = self->setup.lines;
    const struct lx_clocked *line = self->setup.line;
    const int level = lines->ops->get_input(lines);

    if (level < 0) {
        close_gone_lines(self, level);
        return false;
    }
    if ((level != 0) == dg_bus_edges_clock(line->bus)) {
        self->doubtful = false;
        return true;
    }
    if (!self->doubtful) {
        self->doubtful = true;
        lx_timer_at(&self->timeout, dg_after(now, SETTLE));
        return false;
    }
    self->doubtful = false;
    self->counters.lost++;
    /* Before the end of the timeout, at which the level may mean something. */
    (void)dg_bus_edge(line->bus, deadline_of(self) - 1u, level != 0);
    return true;
}

/* Edges that are queued came before the silence. Those that come now are not before its end, which
   is the latest moment that the line knows of. */
static void on_timeout(void *ctx, dg_ns now)
{
    struct lx_gpio *self = ctx;
    const int result = take_edges(self, BATCHES_MAX);

    if (result < 0) {
        close_gone_lines(self, result);
        return;
    }
    if (deadline_of(self) <= now && settle_clock(self, now)) {
        (void)dg_bus_step(self->setup.line->bus, deadline_of(self));
    }
    answer_edge(self);
}

/* Which frames a clock of lx_gpio_rate_hz() is good for. */
static const char *good_for(const struct lx_gpio_rate *rate, char text[GOOD_FOR_MAX])
{
    const uint64_t frames = lx_gpio_rate_frames(rate);
    if (lx_gpio_rate_known(rate)) {
        (void)snprintf(text, GOOD_FOR_MAX, "99.9 %% of frames (%" PRIu64 " seen)", frames);
    } else {
        (void)snprintf(text, GOOD_FOR_MAX,
                       "all of %" PRIu64 " frames seen (99.9 %% is known after %u)", frames,
                       LX_GPIO_RATE_ENOUGH);
    }
    return text;
}

static void complain_of_clock(const struct lx_gpio *self, uint64_t late, uint64_t lost)
{
    const char *name = self->setup.name;
    const struct lx_clocked_protocol *protocol = self->setup.line->protocol;
    const uint32_t rate = lx_gpio_rate_hz(&self->rate);
    char text[GOOD_FOR_MAX];

    if (late > 0) {
        lx_complain("%s: the master's clock is too fast, %" PRIu64 " times %s was set later than "
                    "half a period after its edge; expected at most %" PRIu32 " Hz for %s",
                    name, late, protocol->data, rate, good_for(&self->rate, text));
    }
    if (lost > 0) {
        lx_complain("%s: edges of %s were lost, frames are damaged; expected a clean clock of at "
                    "most %" PRIu32 " Hz for %s",
                    name, protocol->clock, rate, good_for(&self->rate, text));
    }
}

/* Once for each episode of trouble. */
static void report_trouble(struct lx_gpio *self, dg_ns now)
{
    const uint64_t late = self->counters.late - self->seen.late;
    const uint64_t lost = self->counters.lost - self->seen.lost;

    self->seen = self->counters;
    if (late == 0 && lost == 0) {
        return;
    }
    if (self->trouble == 0 || dg_elapsed(now, self->trouble) > EPISODE) {
        complain_of_clock(self, late, lost);
    }
    self->trouble = now;
}

static void report_rate(struct lx_gpio *self)
{
    const bool in_frame = deadline_of(self) != DG_NEVER;
    const uint64_t frames = lx_gpio_rate_frames(&self->rate);
    char text[GOOD_FOR_MAX];

    if (in_frame || self->rate_told == TELL_COUNT || frames < tell_after[self->rate_told]) {
        return;
    }
    while (self->rate_told < TELL_COUNT && frames >= tell_after[self->rate_told]) {
        self->rate_told++;
    }
    lx_note(self->setup.say,
            "%s: %s follows within %" PRIu32 " us of the kernel's time of an edge: a clock up to "
            "%" PRIu32 " Hz works for %s; the time before the kernel's is unknown",
            self->setup.name, self->setup.line->protocol->data,
            lx_gpio_rate_reaction_ns(&self->rate) / 1000u, lx_gpio_rate_hz(&self->rate),
            good_for(&self->rate, text));
}

/* Until the next look, or until there may be something to tell the user. */
static void arm_watch(struct lx_gpio *self, dg_ns now)
{
    const struct lx_gpio_setup *setup = &self->setup;
    const dg_ns hint = lx_clocked_hint(setup->line, setup->say, setup->name, now);

    lx_timer_at(&self->watch, dg_earliest(hint, dg_after(now, WATCH)));
}

/* Kernels before 6.7 wake nobody when a chip goes. */
static void on_watch(void *ctx, dg_ns now)
{
    struct lx_gpio *self = ctx;
    const int level = self->setup.lines->ops->get_input(self->setup.lines);

    if (level < 0) {
        close_gone_lines(self, level);
        return;
    }
    report_trouble(self, now);
    report_rate(self);
    arm_watch(self, now);
}

static int listen_to_edges(struct lx_gpio *self)
{
    sd_event *event = self->setup.event;
    int result = lx_timer_open(&self->timeout, event, on_timeout, self);
    if (result >= 0) {
        result = lx_timer_open(&self->watch, event, on_watch, self);
    }
    if (result >= 0) {
        result = sd_event_add_io(event, &self->io, self->setup.lines->fd, EPOLLIN, on_edges, self);
    }
    return result;
}

int lx_gpio_open(struct lx_gpio *self, const struct lx_gpio_setup *setup, struct lx_error *error)
{
    const struct lx_clocked *line = setup->line;
    *self = (struct lx_gpio){.setup = *setup, .data = line->data};
    lx_gpio_rate_init(&self->rate, line->protocol->master->rises(line->bus));
    const int result = listen_to_edges(self);
    if (result < 0) {
        return lx_fail(error, "no event loop for %s: %s", setup->name, strerror(-result));
    }
    const dg_ns now = lx_now();
    const int level = setup->lines->ops->get_input(setup->lines);
    if (level < 0) {
        return lx_fail(error, "%s: cannot read %s: %s", setup->name, line->protocol->clock,
                       strerror(-level));
    }
    (void)dg_bus_edge(line->bus, now, level != 0);
    answer_edge(self);
    arm_watch(self, now);
    return 0;
}

/* At the latest moment that the line knows of: edges that are queued are still to come. */
void lx_gpio_changed(struct lx_gpio *self)
{
    if (self->setup.lines == NULL) {
        return;
    }
    lx_clocked_look(self->setup.line, 0);
    answer_edge(self);
}

void lx_gpio_close(struct lx_gpio *self)
{
    self->io = sd_event_source_disable_unref(self->io);
    lx_timer_close(&self->timeout);
    lx_timer_close(&self->watch);
    if (self->setup.lines != NULL) {
        self->setup.lines->ops->close(self->setup.lines);
        self->setup.lines = NULL;
    }
}
