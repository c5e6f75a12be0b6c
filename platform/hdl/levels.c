/* SPDX-License-Identifier: MIT */
/*
 * Time and levels: whatever is on its way, and whatever the encoder waits for, happens in the order
 * of its moments. Of what happens at the same picosecond the inputs are first: an edge finds the
 * neighbour's line as it was before.
 */
#include <stdlib.h>

#include "hdl_private.h"

#define RANDOM_FACTOR 1664525u
#define RANDOM_STEP 1013904223u

/* --- queues --- */

static struct hdl_change *nth_level(struct hdl_queue *self, size_t n)
{
    return &self->change[(self->first + n) % self->room];
}

static bool grow_queue(struct hdl_queue *self)
{
    const size_t room = self->room == 0 ? 64u : 2u * self->room;
    struct hdl_change *change = malloc(room * sizeof *change);

    if (change == NULL) {
        return false;
    }
    for (size_t i = 0; i < self->count; i++) {
        change[i] = *nth_level(self, i);
    }
    free(self->change);
    self->change = change;
    self->room = room;
    self->first = 0;
    return true;
}

/* Nothing overtakes what is on its way already. Without memory the newest change replaces the one
   before: the levels at the end are right. */
static void queue_levels(struct hdl_queue *self, int64_t at, int levels)
{
    self->last = at > self->last ? at : self->last;
    self->levels = levels;
    if (self->count == self->room && !grow_queue(self)) {
        if (self->count == 0) {
            return;
        }
        self->count--;
    }
    self->count++;
    *nth_level(self, self->count - 1u) = (struct hdl_change){self->last, levels};
}

static int64_t first_level_at(const struct hdl_queue *self)
{
    return self->count != 0 ? self->change[self->first].at : HDL_NEVER;
}

static int take_levels(struct hdl_queue *self)
{
    const int levels = self->change[self->first].levels;

    self->first = (self->first + 1u) % self->room;
    self->count--;
    return levels;
}

void hdl_queue_free(struct hdl_queue *self)
{
    free(self->change);
    self->change = NULL;
}

/* --- delays --- */

static int64_t jitter(struct dg_hdl *self)
{
    if (self->settings.jitter == 0) {
        return 0;
    }
    self->random = self->random * RANDOM_FACTOR + RANDOM_STEP;
    return (int64_t)((uint64_t)self->random * (self->settings.jitter + UINT64_C(1)) >> 32);
}

void hdl_put(struct dg_hdl *self, int64_t now, int levels)
{
    if (levels != self->out.levels) {
        const struct hdl_settings *settings = &self->settings;
        queue_levels(&self->out, now + settings->tco + settings->delay_out + jitter(self), levels);
    }
}

void hdl_cut(struct dg_hdl *self)
{
    struct hdl_queue *out = &self->out;
    const int64_t sent = self->now + self->settings.tco + self->settings.delay_out;

    while (out->count != 0 && nth_level(out, out->count - 1u)->at > sent) {
        out->count--;
    }
    out->levels = out->count != 0 ? nth_level(out, out->count - 1u)->levels : self->outputs;
    out->last = out->count != 0 ? nth_level(out, out->count - 1u)->at : self->now;
    if (self->wire->reset != NULL) {
        self->wire->reset(self);
        hdl_put(self, self->now, self->wire->idle_out);
    }
}

/* --- time --- */

static int64_t earlier_of(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static int64_t ps_of_ns(uint64_t ns)
{
    return ns > (uint64_t)(HDL_NEVER / HDL_PS_PER_NS) ? HDL_NEVER : (int64_t)ns * HDL_PS_PER_NS;
}

static int64_t own_due(const struct dg_hdl *self)
{
    const int64_t host = earlier_of(ps_of_ns(dg_host_next(self->host)), self->panel_due);

    const int64_t due = earlier_of(host, self->power_at);

    return self->wire->due != NULL ? earlier_of(due, self->wire->due(self)) : due;
}

/* Whoever has changed something of the encoder, or has put a change on its way, ends with this. */
static void note_due(struct dg_hdl *self)
{
    self->due = earlier_of(earlier_of(first_level_at(&self->in), first_level_at(&self->out)),
                           own_due(self));
}

/* The first power: what the encoder has seen of its lines so far is nothing. */
static void switch_power_on(struct dg_hdl *self, int64_t at)
{
    const uint64_t ns = (uint64_t)(at / HDL_PS_PER_NS);

    self->power_at = HDL_NEVER;
    (void)dg_host_power(self->host, ns, true);
    if (self->wire->reset != NULL) {
        self->wire->reset(self);
    } else {
        self->outputs = dg_host_clock(self->host, ns, true) > 0 ? DG_HDL_DATA : 0;
        self->out.levels = self->outputs;
    }
}

/* What the encoder does at `at`. */
static void serve_encoder(struct dg_hdl *self, int64_t at)
{
    if (self->power_at <= at) {
        switch_power_on(self, at);
    }
    if (self->wire->run != NULL && self->wire->due(self) <= at) {
        self->wire->run(self, at);
    }
    self->panel_due = ps_of_ns(dg_host_panel_step(self->panel, (uint64_t)(at / HDL_PS_PER_NS)));
}

void hdl_look(struct dg_hdl *self)
{
    serve_encoder(self, self->now);
    note_due(self);
}

/* What is due up to `until`. */
static void run_due(struct dg_hdl *self, int64_t until)
{
    int64_t in = first_level_at(&self->in);
    int64_t own = own_due(self);

    while (earlier_of(in, own) <= until) {
        /* An encoder that asks for the present again would stop time. */
        const int64_t at = earlier_of(in, own);
        self->now = at > self->now ? at : self->now;
        if (in <= own) {
            self->wire->take(self, self->now, take_levels(&self->in));
        } else {
            serve_encoder(self, self->now);
        }
        const int64_t later = own_due(self);
        in = first_level_at(&self->in);
        own = later > self->now ? later : self->now + 1;
    }
    while (first_level_at(&self->out) <= until) {
        self->outputs = take_levels(&self->out);
    }
    note_due(self);
}

uint64_t hdl_run(struct dg_hdl *self, int64_t now)
{
    const int64_t present = earlier_of(now, HDL_END);
    const int64_t until = present > self->now ? present : self->now;

    if (self->due <= until) {
        run_due(self, until);
    }
    self->now = until;
    return (uint64_t)(until / HDL_PS_PER_NS);
}

int64_t dg_hdl_next(const struct dg_hdl *self)
{
    int64_t next = earlier_of(self->due, self->hint_due);

    /* Time that nobody looks at is time that nobody can steer in. */
    if (self->control != NULL) {
        next = earlier_of(next, self->now + HDL_CONTROL_REST);
    }
    if (next == HDL_NEVER) {
        return DG_HDL_NEVER;
    }
    return next > self->now ? next : self->now + 1;
}

/* Registers of a master begin with anything, and stay there until its first clock: a level that
   lasts since before power-on is no edge, and neither is the return from it. Of an input that
   changes with power-on it counts what it was before, whoever is first in that time step. */
static bool takes_edges(struct dg_hdl *self, int delayed)
{
    const int idle = self->wire->idle_in;

    if (!self->looked) {
        self->looked = true;
        self->power_at = self->now + self->settings.power_on;
        self->due = earlier_of(self->due, self->power_at);
    }
    self->listens = self->listens || (self->power_at == HDL_NEVER &&
                                      (delayed == idle || (self->inputs & ~DG_HDL_BEHIND) == idle));
    return self->listens;
}

const char *dg_hdl_hint(struct dg_hdl *self, int at_end)
{
    uint64_t due;

    if (self == NULL || self->host == NULL) {
        return "";
    }
    return hdl_text(at_end != 0 ? dg_host_hint(self->host, DG_HOST_NEVER, &due) : self->hint);
}

/* @return DG_HDL_HINT, or 0 */
static int look_for_hint(struct dg_hdl *self)
{
    uint64_t due;

    self->hint = dg_host_hint(self->host, (uint64_t)(self->now / HDL_PS_PER_NS), &due);
    self->hint_due = ps_of_ns(due);
    return self->hint != NULL ? DG_HDL_HINT : 0;
}

/* Chance is asked for changes alone: a look in between makes no other trace. Without a cable the
   change is at the encoder at once. */
static void send_inputs(struct dg_hdl *self, int levels)
{
    const int64_t at = self->now + self->settings.delay_in + jitter(self);

    if (at > self->now || self->in.count != 0) {
        queue_levels(&self->in, at, levels);
    } else {
        self->in.last = at;
        self->in.levels = levels;
        self->wire->take(self, self->now, levels);
    }
    note_due(self);
}

int dg_hdl_wires(struct dg_hdl *self, int64_t now, int inputs)
{
    const uint64_t ns = hdl_run(self, now);
    const int delayed = inputs & ~DG_HDL_BEHIND;

    if (self->control != NULL) {
        hdl_control_poll(self);
    }
    const bool changes = takes_edges(self, delayed) && delayed != self->in.levels;
    if (changes) {
        send_inputs(self, delayed);
    }
    if (((inputs ^ self->inputs) & DG_HDL_BEHIND) != 0 && self->wire == &hdl_clocked) {
        (void)dg_host_behind(self->host, ns, (inputs & DG_HDL_BEHIND) != 0);
        note_due(self);
    }
    self->inputs = inputs;
    /* What there is to tell begins with power or its end, and waits: never with an edge. */
    self->hint = NULL;
    return self->outputs | (changes && self->hint_due == HDL_NEVER ? 0 : look_for_hint(self));
}

/* --- BiSS and SSI --- */

static void take_clock(struct dg_hdl *self, int64_t now, int levels)
{
    (void)dg_host_clock(self->host, (uint64_t)(now / HDL_PS_PER_NS), (levels & DG_HDL_CLOCK) != 0);
}

static void heard_edge(struct dg_hdl *self, const struct dg_host_event *event)
{
    hdl_put(self, self->now, event->data[0] != 0 ? DG_HDL_DATA : 0);
}

const struct hdl_wire_ops hdl_clocked = {
    .idle_in = DG_HDL_CLOCK,
    .idle_out = DG_HDL_DATA,
    .take = take_clock,
    .heard = heard_edge,
};
