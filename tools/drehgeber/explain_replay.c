/* SPDX-License-Identifier: MIT */
#include "explain_replay.h"

#include <string.h>

#include "drehgeber/bits.h"

/* Answers are not later than this, what comes by itself not further away. */
#define WINDOW DG_S(1)
/* The model does not live longer in a pause. */
#define PAUSE_MAX DG_S(60)
#define WIDTH_MAX 4u
#define NOWHERE SIZE_MAX
/* Silence between an answer and the next request, in characters: more than the longest timeout. */
#define SILENCE 6u

enum who {
    MODEL,
    PROBE,
};

/* Where a position is in a message. */
struct place {
    size_t at; /* NOWHERE */
    size_t width;
    bool least_first;
};

/* What the recording has for something that the probe has said. */
struct partner {
    uint64_t index; /* explain_replay.end: nothing */
    bool solicited;
    bool elsewhere; /* its position is of another moment than the model's shaft */
    struct place place;
};

static struct explain_message *message_at(struct explain_replay *self, uint64_t index)
{
    return &self->ring[index % EXPLAIN_RING];
}

/* The moment of the model that belongs to one of the recording. */
static dg_ns model_time(const struct explain_replay *self, dg_ns at)
{
    return EXPLAIN_BEGIN + dg_elapsed(at, self->base) + self->slip;
}

/* --- what they say --- */

static struct explain_said *begin_said(struct explain_voice *voice,
                                       const struct dg_host_event *event)
{
    struct explain_said *said = &voice->said[voice->count];
    if (voice->count == EXPLAIN_SAID) {
        return NULL;
    }
    voice->count++;
    *said = (struct explain_said){.at = event->at};
    return said;
}

static void append_said(struct explain_said *said, const struct dg_host_event *event)
{
    const size_t room = sizeof said->bytes - said->n;
    const size_t n = event->length < room ? event->length : room;
    memcpy(said->bytes + said->n, event->data, n);
    said->n += n;
}

/* Characters are one message: an encoder says one at a time. */
static void hear_event(struct explain_replay *self, enum who who, const struct dg_host_event *event)
{
    struct explain_voice *voice = &self->voices[who];
    if (event->kind == DG_HOST_BYTES && event->length > 0 && (event->flags & DG_HOST_START) == 0) {
        const bool more = voice->count > 0;
        struct explain_said *said = more ? &voice->said[0] : begin_said(voice, event);
        append_said(said, event);
        self->busy = event->at + (dg_ns)event->length * event->id;
    } else if (event->kind == DG_HOST_CAN) {
        struct explain_said *said = begin_said(voice, event);
        if (said != NULL) {
            said->key = event->id | ((event->flags & DG_HOST_REMOTE) != 0 ? EXPLAIN_REMOTE : 0u);
            append_said(said, event);
        }
    }
}

static void step_encoder(struct explain_replay *self, enum who who, dg_ns to)
{
    struct dg_host *host = who == MODEL ? self->model->model : self->model->probe;
    struct dg_host_event event;
    (void)dg_host_step(host, to);
    while (dg_host_receive(host, &event) != 0) {
        hear_event(self, who, &event);
    }
}

/* --- positions --- */

static uint64_t bytes_number_at(const uint8_t *bytes, const struct place *place)
{
    uint64_t value = 0;
    for (size_t i = 0; i < place->width; i++) {
        value = value << 8 | bytes[place->at + (place->least_first ? place->width - 1u - i : i)];
    }
    return value;
}

/* One that turns has moved on since it looked. */
static bool is_position(const struct explain_replay *self, uint64_t value, uint64_t position)
{
    const uint64_t off = value > position ? value - position : position - value;
    return off <= (self->frames ? self->model->turn : 0u);
}

/* Where the probe has told its position. */
static struct place find_bytes(const struct explain_replay *self, const struct explain_said *said)
{
    struct place place = {.width = WIDTH_MAX};
    const size_t least = (self->model->bits + 7u) / 8u;
    uint64_t position;
    if (dg_host_position(self->model->probe, said->at, &position) != DG_HOST_OK) {
        place.at = NOWHERE;
        return place;
    }
    for (; place.width >= least && place.width > 1u; place.width--) {
        for (place.at = 0; place.at + place.width <= said->n; place.at++) {
            for (unsigned order = 0; order < 2u; order++) {
                place.least_first = order == 1u;
                if (is_position(self, bytes_number_at(said->bytes, &place), position)) {
                    return place;
                }
            }
        }
    }
    place.at = NOWHERE;
    return place;
}

/* --- what belongs together --- */

/* The next message of the recording that may be this one, or `end`. */
static uint64_t find_partner(struct explain_replay *self, const struct explain_said *said,
                             bool solicited)
{
    uint64_t index = solicited && self->asked >= self->first ? self->asked + 1u : self->first;
    const uint32_t asked = self->question.key;
    for (; index < self->end; index++) {
        const struct explain_message *message = message_at(self, index);
        const dg_ns at = model_time(self, message->at);
        const bool again = !message->ours && !message->other && message->key == asked;
        const bool free = message->ours && !message->matched && !message->waited;
        if (at > said->at + WINDOW || (solicited && again)) {
            break;
        }
        if (free && message->key == said->key && at + WINDOW >= said->at) {
            return index;
        }
    }
    return self->end;
}

/* What is known of a kind of message; the last row is for those that no row is left for. */
static struct explain_kind *message_kind_of(struct explain_replay *self, uint32_t key)
{
    size_t i = 0;
    while (i < self->kind_count && self->kinds[i].key != key) {
        i++;
    }
    if (i == self->kind_count && i + 1u < EXPLAIN_KINDS) {
        self->kinds[i].key = key;
        self->kind_count++;
    }
    return &self->kinds[i];
}

static dg_ns recorded_time(const struct explain_replay *self, dg_ns at)
{
    return self->base + dg_elapsed(at, EXPLAIN_BEGIN + self->slip);
}

/* One of the two is not NULL. */
static void tell_difference(struct explain_replay *self, const struct explain_message *came,
                            const struct explain_said *model, bool solicited)
{
    const struct explain_difference difference = {
        .at = came != NULL    ? came->at
              : model != NULL ? recorded_time(self, model->at)
                              : self->base,
        .asked = solicited && self->was_asked ? &self->question : NULL,
        .came = came,
        .model = model,
    };
    self->differs(self->ctx, &difference);
}

/* Bytes that turn with the shaft and are no position: speeds, raw positions and their check sums.
   The model's shaft is at rest. */
static bool is_turning(const struct partner *partner, const struct explain_said *model,
                       const struct explain_said *probe, size_t at)
{
    const struct place *place = &partner->place;
    const bool inside = place->at != NOWHERE && at >= place->at && at < place->at + place->width;
    return inside ? partner->elsewhere
                  : probe->n == model->n && probe->bytes[at] != model->bytes[at];
}

/* Frames have their check sums in hardware; of characters every byte counts. */
static bool is_same_message(const struct explain_replay *self, const struct partner *partner,
                            const struct explain_message *came, size_t index)
{
    const struct explain_said *model = &self->voices[MODEL].said[index];
    const struct explain_said *probe = &self->voices[PROBE].said[index];
    if (came->n != model->n) {
        return false;
    }
    for (size_t i = 0; i < came->n; i++) {
        const bool turning = self->frames && is_turning(partner, model, probe, i);
        if (came->bytes[i] != model->bytes[i] && !turning) {
            return false;
        }
    }
    return true;
}

/* The model says what nobody in the recording did. What comes by itself may come at another pace.
 */
static void tell_surplus(struct explain_replay *self, const struct explain_said *model,
                         bool solicited)
{
    struct explain_kind *kind = message_kind_of(self, model->key);
    const dg_ns since = dg_elapsed(recorded_time(self, model->at), kind->matched);
    const bool usual = kind->known && since <= WINDOW;
    if (solicited || (!usual && !kind->missing)) {
        tell_difference(self, NULL, model, solicited);
        kind->missing |= !solicited;
    }
}

/* --- both, one behind the other --- */

/* The first of its kind behind a request that it was not going to say anyway. */
static bool is_solicited(struct explain_replay *self, const struct explain_said *said)
{
    struct explain_kind *kind = message_kind_of(self, said->key);
    const bool first = kind->answered != self->asked + 1u;
    kind->answered = self->asked + 1u;
    return self->was_asked && (!self->frames || (first && said->at < self->planned));
}

/* What the probe has said tells where the model's shaft is to be. */
static void place_model_shaft(struct explain_replay *self, struct partner partners[EXPLAIN_SAID])
{
    const struct explain_voice *voice = &self->voices[PROBE];
    bool placed = false;
    for (size_t i = 0; i < voice->count; i++) {
        const struct explain_said *said = &voice->said[i];
        struct partner *partner = &partners[i];
        *partner = (struct partner){.solicited = is_solicited(self, said)};
        partner->index = find_partner(self, said, partner->solicited);
        partner->place = find_bytes(self, said);
        partner->elsewhere = placed;
        if (partner->index == self->end) {
            continue;
        }
        struct explain_message *message = message_at(self, partner->index);
        message->matched = true;
        if (!placed && partner->place.at != NOWHERE && message->n == said->n) {
            (void)explain_model_place(self->model, self->now,
                                      bytes_number_at(message->bytes, &partner->place));
            placed = true;
        }
    }
}

static void compare_voices(struct explain_replay *self, const struct partner partners[EXPLAIN_SAID])
{
    const struct explain_voice *model = &self->voices[MODEL];
    const struct explain_voice *probe = &self->voices[PROBE];
    for (size_t i = 0; i < model->count; i++) {
        const struct explain_said *said = &model->said[i];
        const bool known = i < probe->count && probe->said[i].key == said->key;
        if (!known || partners[i].index == self->end) {
            tell_surplus(self, said, known && partners[i].solicited);
            continue;
        }
        const struct explain_message *came = message_at(self, partners[i].index);
        struct explain_kind *kind = message_kind_of(self, said->key);
        kind->known = true;
        kind->matched = came->at;
        kind->spontaneous |= !partners[i].solicited;
        if (!is_same_message(self, &partners[i], came, i)) {
            tell_difference(self, came, said, partners[i].solicited);
        }
    }
}

static void send_message(struct dg_host *host, const struct explain_message *message, bool frames,
                         dg_ns at)
{
    for (size_t done = 0; done < message->n || (frames && done == 0); done += 16u) {
        struct dg_host_event event = {.at = at, .kind = DG_HOST_BYTES, .id = message->each};
        const size_t left = message->n - done;
        event.length = (uint8_t)(left < sizeof event.data ? left : sizeof event.data);
        memcpy(event.data, message->bytes + done, event.length);
        if (frames) {
            event.kind = DG_HOST_CAN;
            event.id = message->key & ~EXPLAIN_REMOTE;
            event.flags = (message->key & EXPLAIN_REMOTE) != 0 ? DG_HOST_REMOTE : 0;
        }
        (void)dg_host_send(host, &event);
        at += 16u * (dg_ns)message->each;
    }
}

/* Both live up to `to`, and are told `message` then; NULL: nothing. */
static void live_both(struct explain_replay *self, dg_ns to, const struct explain_message *message)
{
    struct partner partners[EXPLAIN_SAID] = {{.index = 0}};
    self->voices[MODEL].count = 0;
    self->voices[PROBE].count = 0;
    if (message != NULL) {
        send_message(self->model->probe, message, self->frames, to);
    }
    step_encoder(self, PROBE, to);
    place_model_shaft(self, partners);
    if (message != NULL) {
        send_message(self->model->model, message, self->frames, to);
    }
    step_encoder(self, MODEL, to);
    self->now = to;
    compare_voices(self, partners);
}

/* Deadline after deadline, so that what is said is seen before the model says it. */
static void live_until(struct explain_replay *self, dg_ns to)
{
    dg_ns next;
    while ((next = dg_host_next(self->model->probe)) < to) {
        live_both(self, next > self->now ? next : self->now + 1u, NULL);
    }
    if (to > self->now) {
        live_both(self, to, NULL);
    }
}

/* --- the recording --- */

/* Up to a second behind the next message, as far as there is room. */
static int fill_ring(struct explain_replay *self, struct lx_error *error)
{
    while (!self->over && self->end - self->first < EXPLAIN_RING) {
        struct explain_message *last = message_at(self, self->end);
        if (self->end > self->next + 1u &&
            message_at(self, self->end - 1u)->at > message_at(self, self->next)->at + WINDOW) {
            return 0;
        }
        const int found = explain_talk_next(self->talk, last, error);
        if (found < 0) {
            return -1;
        }
        self->over = found == 0;
        self->base = self->end == 0 ? last->at : self->base;
        self->end += found == 1 ? 1u : 0u;
    }
    return 0;
}

/* What comes by itself may come at another pace. */
static bool is_usual(struct explain_replay *self, const struct explain_message *message)
{
    const struct explain_kind *kind = message_kind_of(self, message->key);
    return self->frames && kind->spontaneous && dg_elapsed(message->at, kind->matched) <= WINDOW;
}

static bool is_open(const struct explain_message *message)
{
    return message->ours && !message->other && !message->matched && !message->waited;
}

/* Nobody will answer it any more. */
static void drop_message(struct explain_replay *self)
{
    const struct explain_message *message = message_at(self, self->first);
    if (is_open(message) && !is_usual(self, message)) {
        tell_difference(self, message, NULL, false);
    }
    self->messages += message->ours && !message->other ? 1u : 0u;
    self->first++;
}

/* What is long ago, and what the model has answered; anything if there is no room. */
static void forget_messages(struct explain_replay *self)
{
    while (self->first < self->next) {
        const struct explain_message *message = message_at(self, self->first);
        const bool full = self->end - self->first == EXPLAIN_RING;
        if (is_open(message) && model_time(self, message->at) + WINDOW > self->now && !full) {
            return;
        }
        drop_message(self);
    }
}

/* The model is slower than the encoder was: what follows waits until it has answered, or is not
   going to. */
static void wait_for_model(struct explain_replay *self, const struct explain_message *message)
{
    const dg_ns limit = self->now + WINDOW;
    dg_ns next;
    while (!message->matched && (next = dg_host_next(self->model->probe)) <= limit) {
        live_both(self, next > self->now ? next : self->now + 1u, NULL);
    }
    self->slip += dg_elapsed(self->now, model_time(self, message->at));
}

/* An encoder that greets without being asked has got its power. */
static bool is_greeting(const struct explain_replay *self, const struct explain_message *message)
{
    const struct explain_said *greeting = &self->greeting;
    return greeting->n > 0 && message->key == greeting->key && message->n == greeting->n &&
           memcmp(message->bytes, greeting->bytes, greeting->n) == 0;
}

static void cycle_power(struct explain_replay *self)
{
    (void)dg_host_power(self->model->model, self->now, true);
    (void)dg_host_power(self->model->probe, self->now, true);
    self->was_asked = false;
}

/* Everything the encoder has said up to now gets its partner, or is told to have none. */
static void settle_messages(struct explain_replay *self)
{
    for (uint64_t i = self->first; i < self->next; i++) {
        struct explain_message *message = message_at(self, i);
        if (!is_open(message) || is_usual(self, message)) {
            continue;
        }
        wait_for_model(self, message);
        if (!message->matched && is_greeting(self, message)) {
            cycle_power(self);
            wait_for_model(self, message);
        }
        message->waited = !message->matched;
        if (message->waited) {
            tell_difference(self, message, NULL, true);
        }
    }
}

/* The model lives up to a moment of the recording, with a pause of a minute at most.
   @return that moment of the model */
static dg_ns live_along(struct explain_replay *self, dg_ns recorded)
{
    const dg_ns at = model_time(self, recorded);
    const dg_ns most = self->now + PAUSE_MAX;
    self->base += dg_elapsed(at, most);
    live_until(self, at < most ? at : most);
    return at < most ? at : most;
}

/* Ask the model what the encoder was asked. */
static void ask_model(struct explain_replay *self, const struct explain_message *message)
{
    settle_messages(self);
    const dg_ns at = live_along(self, message->at);
    const dg_ns free = self->busy + SILENCE * (dg_ns)message->each;
    live_until(self, free);
    self->slip += dg_elapsed(self->now, at);
    self->planned = dg_host_next(self->model->probe);
    self->asked = self->next;
    self->question = *message;
    self->was_asked = true;
    explain_model_move(self->model, self->now, self->frames);
    live_both(self, self->now, message);
}

/* The next message of the recording. */
static void take_next(struct explain_replay *self)
{
    const struct explain_message *message = message_at(self, self->next);
    if (!message->ours && !message->other) {
        ask_model(self, message);
    } else if (!message->other) {
        (void)live_along(self, message->at);
    }
    self->next++;
}

/* What is said at power-on. */
static void begin_replay(struct explain_replay *self)
{
    explain_model_move(self->model, EXPLAIN_BEGIN, self->frames);
    step_encoder(self, PROBE, EXPLAIN_BEGIN);
    step_encoder(self, MODEL, EXPLAIN_BEGIN);
    if (self->frames && self->voices[PROBE].count > 0) {
        self->greeting = self->voices[PROBE].said[0];
    }
    self->now = EXPLAIN_BEGIN;
}

int explain_replay_run(struct explain_replay *self, struct lx_error *error)
{
    begin_replay(self);
    for (;;) {
        if (fill_ring(self, error) != 0) {
            return -1;
        }
        if (self->next == self->end) {
            break;
        }
        take_next(self);
        forget_messages(self);
    }
    settle_messages(self);
    live_until(self, self->now + WINDOW);
    while (self->first < self->end) {
        drop_message(self);
    }
    return 0;
}
