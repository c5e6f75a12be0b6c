/* SPDX-License-Identifier: MIT */
#include "explain_edges.h"

#include <stdio.h>
#include <string.h>

#include "drehgeber/bits.h"

#define PAUSE_MAX DG_S(60)
/* A pause that ends a frame, in halves of a clock. */
#define PAUSE_HALVES 8u
/* Less is no frame, but an end of one. */
#define BITS_MIN 4u
/* A counter in each frame comes round after so many. */
#define ROUND 63u
/* Between two frames that look for the counter. */
#define BETWEEN DG_MS(1)

enum who {
    MODEL,
    PROBE,
};

/* Where a position is in a frame, and how. */
struct place {
    bool found;
    bool gray;
    size_t at;
};

static struct dg_host *host_of(const struct explain_edges *self, enum who who)
{
    return who == MODEL ? self->model->model : self->model->probe;
}

/* --- the model --- */

static void step_host(struct explain_edges *self, enum who who, dg_ns to)
{
    struct dg_host_event event;
    (void)dg_host_step(host_of(self, who), to);
    while (dg_host_receive(host_of(self, who), &event) != 0) {
        if (event.kind == DG_HOST_EDGE) {
            self->levels[who] = event.data[0] != 0;
        }
    }
}

/* One of the two is clocked as the recording has it. */
static void replay_clock(struct explain_edges *self, enum who who)
{
    struct explain_frame *said = &self->said[who];
    const struct explain_frame *heard = &self->heard;
    said->count = 0;
    for (size_t i = 0; i < heard->edges; i++) {
        const dg_ns at = self->now + (heard->at[i] - heard->at[0]);
        step_host(self, who, at - 1u);
        if (!heard->level[i] && said->count < EXPLAIN_BITS_MAX) {
            said->bits[said->count++] = self->levels[who];
        }
        const int level = dg_host_clock(host_of(self, who), at, heard->level[i]);
        step_host(self, who, at);
        self->levels[who] = level >= 0 ? level != 0 : self->levels[who];
    }
}

static uint64_t bits_number_at(const struct explain_frame *frame, size_t at, unsigned n)
{
    uint64_t value = 0;
    for (size_t i = 0; i < n; i++) {
        value = value << 1 | frame->bits[at + i];
    }
    return value;
}

static uint64_t from_gray(uint64_t value)
{
    for (unsigned shift = 1; shift < 64u; shift <<= 1) {
        value ^= value >> shift;
    }
    return value;
}

/* Where the probe has told its position. */
static struct place find_bits(const struct explain_edges *self)
{
    const struct explain_frame *said = &self->said[PROBE];
    const unsigned n = self->model->bits;
    struct place place = {.found = false};
    dg_ns at;
    uint64_t counts;
    if (dg_host_latched(self->model->probe, &at, &counts) != DG_HOST_OK || n == 0) {
        return place;
    }
    for (place.at = 0; place.at + n <= said->count; place.at++) {
        const uint64_t value = bits_number_at(said, place.at, n);
        place.gray = from_gray(value) == counts;
        place.found = place.gray || value == counts;
        if (place.found) {
            return place;
        }
    }
    return place;
}

static void replay_once(struct explain_edges *self)
{
    explain_model_move(self->model, self->now, false);
    replay_clock(self, PROBE);
    const struct place place = find_bits(self);
    if (place.found && place.at + self->model->bits <= self->heard.count) {
        const uint64_t value = bits_number_at(&self->heard, place.at, self->model->bits);
        (void)explain_model_place(self->model, self->now, place.gray ? from_gray(value) : value);
    }
    replay_clock(self, MODEL);
    self->now += self->heard.at[self->heard.edges - 1u] - self->heard.at[0];
}

static bool is_same_frame(const struct explain_edges *self)
{
    const struct explain_frame *model = &self->said[MODEL];
    return self->heard.count == model->count &&
           memcmp(self->heard.bits, model->bits, model->count * sizeof model->bits[0]) == 0;
}

/* Where counters in frames stand is not known to who comes later, or behind a frame that is
   missing: a frame is asked for until it is that of the recording. */
static void align_clock(struct explain_edges *self)
{
    for (unsigned i = 0; i < ROUND && !is_same_frame(self); i++) {
        self->now += BETWEEN;
        self->slip += BETWEEN + (self->heard.at[self->heard.edges - 1u] - self->heard.at[0]);
        replay_once(self);
    }
}

/* --- frames --- */

static size_t pack_bits(const struct explain_frame *frame, uint8_t bytes[EXPLAIN_BYTES_MAX])
{
    memset(bytes, 0, EXPLAIN_BYTES_MAX);
    for (size_t i = 0; i < frame->count; i++) {
        bytes[i / 8u] |= (uint8_t)(frame->bits[i] ? 0x80u >> i % 8u : 0u);
    }
    return (frame->count + 7u) / 8u;
}

static void compare_frame(struct explain_edges *self, const struct explain_message *came)
{
    struct explain_said model = {.at = came->at};
    struct explain_difference difference = {.at = came->at, .came = came, .model = &model};
    const dg_ns at = EXPLAIN_BEGIN + dg_elapsed(came->at, self->base) + self->slip;
    const dg_ns most = self->now + PAUSE_MAX;
    self->base += dg_elapsed(at, most);
    self->now = at < most ? (at > self->now ? at : self->now) : most;
    replay_once(self);
    if (came->n * 8u < BITS_MIN) {
        return;
    }
    if (self->lost) {
        align_clock(self);
    }
    const bool same = is_same_frame(self);
    if (!same) {
        model.n = pack_bits(&self->said[MODEL], model.bytes);
        self->differs(self->ctx, &difference);
    }
    self->lost = !same && self->same; /* one that is always different is not looked for */
    self->same = same;
}

/* The frame is over. */
static void end_frame(struct explain_edges *self)
{
    struct explain_frame *heard = &self->heard;
    struct explain_message message = {.ours = true};
    if (heard->edges == 0) {
        return;
    }
    message.at = heard->at[0];
    message.end = heard->at[heard->edges - 1u];
    message.n = pack_bits(heard, message.bytes);
    (void)snprintf(message.text, sizeof message.text, "frame of %zu bits", heard->count);
    if (self->model != NULL) {
        compare_frame(self, &message);
    }
    if (heard->count >= BITS_MIN) {
        self->messages++;
        self->frame(self->ctx, &message);
    }
    heard->edges = 0;
    heard->count = 0;
}

static void take_edge(struct explain_edges *self, dg_ns at, bool level)
{
    struct explain_frame *heard = &self->heard;
    const dg_ns since = heard->edges == 0 ? 0 : at - heard->at[heard->edges - 1u];
    if (heard->edges > 0 && since > 0 && since < self->half) {
        self->half = since;
    }
    if (heard->edges == EXPLAIN_EDGES_MAX ||
        (self->half != DG_NEVER && since > PAUSE_HALVES * self->half)) {
        end_frame(self);
    }
    if (!level && heard->count < EXPLAIN_BITS_MAX) {
        heard->bits[heard->count++] = self->data;
    }
    heard->at[heard->edges] = at;
    heard->level[heard->edges++] = level;
}

static void take_edge_event(struct explain_edges *self, const struct dg_tap_event *event)
{
    if (!self->begun) {
        self->begun = true;
        self->base = event->at;
        self->clock = true;
    }
    if (event->levels.clock != self->clock) {
        take_edge(self, event->at, event->levels.clock);
    }
    self->clock = event->levels.clock;
    self->data = event->levels.data;
}

int explain_edges_run(struct explain_edges *self, struct lx_error *error)
{
    int found;
    self->half = DG_NEVER;
    self->data = true;
    self->lost = true;
    self->same = true;
    self->now = EXPLAIN_BEGIN;
    if (self->model != NULL) { /* a clock that stays high says what the line is */
        self->levels[PROBE] = dg_host_clock(self->model->probe, EXPLAIN_BEGIN, true) > 0;
        self->levels[MODEL] = dg_host_clock(self->model->model, EXPLAIN_BEGIN, true) > 0;
    }
    do {
        if (!self->talk->held) {
            found = explain_source_next(self->talk->source, &self->talk->event, error);
        } else {
            found = 1;
        }
        self->talk->held = false;
        if (found == 1) {
            take_edge_event(self, &self->talk->event);
        }
    } while (found == 1);
    end_frame(self);
    return found;
}
