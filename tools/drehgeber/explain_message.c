/* SPDX-License-Identifier: MIT */
#include "explain_message.h"

#include <stdlib.h>
#include <string.h>

#include "drehgeber/devices.h"

/* A pause of the master that ends a request, in characters. An encoder speaks only when it is
   asked: pauses in a reply are those of whoever has recorded it. */
#define PAUSE UINT64_C(4)

static enum dg_medium medium_of(const struct dg_tap_event *event)
{
    return event->kind == DG_TAP_CHARACTER ? DG_MEDIUM_CHARACTERS
           : event->kind == DG_TAP_FRAME   ? DG_MEDIUM_FRAMES
                                           : DG_MEDIUM_EDGES;
}

static const struct dg_words *find_words(enum dg_medium medium)
{
    for (size_t i = 0; i < dg_words_count; i++) {
        if (dg_words_list[i]->stack->medium == medium) {
            return dg_words_list[i];
        }
    }
    return NULL;
}

static void on_line(void *ctx, const struct dg_words_line *line)
{
    struct explain_message *message = ((struct explain_talk *)ctx)->told;
    message->clause = line->clause;
    (void)snprintf(message->text, sizeof message->text, "%s", line->text);
}

int explain_talk_begin(struct explain_talk *self, struct lx_error *error)
{
    const int found = explain_source_next(self->source, &self->event, error);
    if (found != 1) {
        return found;
    }
    self->held = true;
    self->medium = medium_of(&self->event);
    if (self->wire.words == NULL) {
        self->wire.words = find_words(self->medium);
    }
    self->wire.to = (struct dg_words_to){on_line, self};
    if (self->wire.words != NULL) {
        self->wire.memory = lx_allocate(self->wire.words->size, "words", error);
    }
    return self->wire.words != NULL && self->wire.memory == NULL ? -1 : 1;
}

void explain_talk_end(struct explain_talk *self)
{
    free(self->wire.memory);
    self->wire.memory = NULL;
}

/* @return 1; 0: the recording is over; -1 */
static int take_event(struct explain_talk *self, struct lx_error *error)
{
    if (self->held) {
        return 1;
    }
    const int found = explain_source_next(self->source, &self->event, error);
    self->held = found == 1;
    return found;
}

static void add_side(const struct explain_talk *self, struct explain_message *to)
{
    const struct dg_words *words = self->wire.words;
    int side = DG_WORDS_AS_TOLD;
    if (words != NULL && words->side != NULL) {
        side = words->side(&self->event, self->address);
    }
    to->ours = side == DG_WORDS_AS_TOLD ? self->event.ours : side == DG_WORDS_ENCODER;
    to->other = side == DG_WORDS_OTHER;
}

/* --- frames --- */

static int take_can_frame(struct explain_talk *self, struct explain_message *to,
                          struct lx_error *error)
{
    const struct dg_can_frame *frame = &self->event.frame;
    const int found = take_event(self, error);
    if (found != 1) {
        return found;
    }
    to->at = self->event.at;
    to->end = self->event.at;
    to->key = frame->id | (frame->rtr ? EXPLAIN_REMOTE : 0u);
    to->n = frame->dlc;
    memcpy(to->bytes, frame->data, sizeof frame->data);
    add_side(self, to);
    self->held = false;
    return 1;
}

/* --- characters --- */

static dg_ns duration(const struct dg_tap_event *event)
{
    const struct dg_host_uart uart = {
        .baud = event->character.baud,
        .parity = (uint8_t)event->character.parity,
    };
    return dg_host_uart_ns(&uart, 1);
}

static bool continues(const struct explain_message *to, const struct dg_tap_event *event)
{
    const dg_ns start = dg_elapsed(event->at, duration(event));
    return event->ours == to->ours && to->n < EXPLAIN_BYTES_MAX &&
           (to->ours || dg_elapsed(start, to->end) <= PAUSE * to->each);
}

static int take_characters(struct explain_talk *self, struct explain_message *to,
                           struct lx_error *error)
{
    int found;
    while ((found = take_event(self, error)) == 1) {
        const struct dg_tap_event *event = &self->event;
        if (to->n == 0) {
            add_side(self, to);
            to->ours = event->ours;
            to->each = (uint32_t)duration(event);
            to->at = dg_elapsed(event->at, duration(event));
        } else if (!continues(to, event)) {
            return 1;
        }
        to->damaged |= event->character.damaged;
        to->bytes[to->n++] = event->character.byte;
        to->end = event->at;
        self->held = false;
    }
    return found < 0 ? -1 : to->n > 0;
}

int explain_talk_next(struct explain_talk *self, struct explain_message *to, struct lx_error *error)
{
    *to = (struct explain_message){.at = 0};
    const int found = self->medium == DG_MEDIUM_FRAMES ? take_can_frame(self, to, error)
                                                       : take_characters(self, to, error);
    if (found == 1) {
        explain_talk_say(self, to);
    }
    return found;
}

/* --- words --- */

static void say_frame(struct explain_talk *self, const struct explain_message *message)
{
    struct dg_tap_event event = {.at = message->at, .kind = DG_TAP_FRAME, .ours = message->ours};
    event.frame.id = (uint16_t)message->key;
    event.frame.rtr = (message->key & EXPLAIN_REMOTE) != 0;
    event.frame.dlc = (uint8_t)message->n;
    memcpy(event.frame.data, message->bytes, sizeof event.frame.data);
    dg_words_event(&self->wire, &event);
}

/* One behind the other, as pauses do not end it. */
static void say_characters(struct explain_talk *self, const struct explain_message *message)
{
    struct dg_tap_event event = {.kind = DG_TAP_CHARACTER, .ours = message->ours};
    for (size_t i = 0; i < message->n; i++) {
        event.at = message->at + (i + 1u) * message->each;
        event.character.baud = (uint32_t)(11u * DG_S(1) / message->each);
        event.character.parity = 'E';
        event.character.byte = message->bytes[i];
        event.character.damaged = message->damaged && i + 1u == message->n;
        dg_words_event(&self->wire, &event);
    }
    (void)dg_words_step(&self->wire, DG_NEVER);
}

void explain_talk_say(struct explain_talk *self, struct explain_message *message)
{
    self->told = message;
    if (self->wire.words == NULL || message->n > EXPLAIN_BYTES_MAX) {
        return;
    }
    if (self->medium == DG_MEDIUM_FRAMES) {
        say_frame(self, message);
    } else {
        say_characters(self, message);
    }
}
