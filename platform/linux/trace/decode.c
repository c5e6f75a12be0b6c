/* SPDX-License-Identifier: MIT */
/*
 * Events become lines. Only RS485 needs memory of what came before: characters add up to a frame
 *
 *   40 42 02 . . . . 40 42 00 00 30 39 0B . . . . . . . . . . . . . .
 *   `request `       `reply: the other direction ends the request   ` 44 bits of silence end it
 */
#include "decode.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "uart.h"

/* Silence that ends a frame: the longest timeout of a request, 5.1.1.1. */
#define SILENCE_BITS 44u
#define CHARACTER_BITS 11u

/* Of a long frame, so that there is room for what is wrong with it. */
#define BYTES_SHOWN 16u

static const char cut[] = "...";

void lx_text_add(struct lx_text *self, const char *format, ...)
{
    const size_t room = sizeof self->text - self->length;
    va_list arguments;
    va_start(arguments, format);
    const int n = vsnprintf(self->text + self->length, room, format, arguments);
    va_end(arguments);
    if (n < 0) {
        return;
    }
    if ((size_t)n < room) {
        self->length += (size_t)n;
        return;
    }
    self->length = sizeof self->text - 1;
    memcpy(self->text + sizeof self->text - sizeof cut, cut, sizeof cut);
}

void lx_text_bytes(struct lx_text *self, const char *before, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n && i < BYTES_SHOWN; i++) {
        lx_text_add(self, "%s %02X", i == 0 ? before : "", bytes[i]);
    }
    lx_text_add(self, "%s", n > BYTES_SHOWN ? " ..." : "");
}

void lx_decoder_init(struct lx_decoder *self,
                     void (*line)(void *ctx, dg_ns at, bool ours, const char *text), void *ctx)
{
    memset(self, 0, sizeof *self);
    self->line = line;
    self->ctx = ctx;
}

/* A character that starts from then on begins a new frame. */
static dg_ns frame_end(const struct lx_decoder *self)
{
    return dg_after(self->last, dg_bit_times_ns(SILENCE_BITS, self->baud));
}

/* A character that started before frame_end() would have been told by then. */
static dg_ns wait_end(const struct lx_decoder *self)
{
    return dg_after(self->last, dg_bit_times_ns(SILENCE_BITS + CHARACTER_BITS, self->baud));
}

static void give_frame(struct lx_decoder *self)
{
    struct lx_text text = {.length = 0};
    if (self->length == 0) {
        return;
    }
    lx_decode_hf(self, &text);
    self->length = 0;
    self->line(self->ctx, self->begin, self->ours, text.text);
}

/* Characters that come in a bunch overlap, and so belong together. */
static void on_character(struct lx_decoder *self, const struct dg_tap_event *event)
{
    const uint32_t bits = lx_character_bits(event->character.parity);
    const dg_ns duration = dg_bit_times_ns(bits, event->character.baud);
    const dg_ns start = event->at > duration ? event->at - duration : 0;
    if (event->ours != self->ours || start >= frame_end(self)) {
        give_frame(self);
    }
    if (self->length == 0) {
        self->begin = start;
        self->ours = event->ours;
        self->damaged = false;
    }
    if (self->length < sizeof self->bytes) {
        self->bytes[self->length] = event->character.byte;
    }
    self->length = (uint16_t)(self->length < UINT16_MAX ? self->length + 1u : UINT16_MAX);
    self->damaged |= event->character.damaged;
    self->baud = event->character.baud;
    self->last = event->at;
}

static void on_frame(struct lx_decoder *self, const struct dg_tap_event *event)
{
    struct lx_text text = {.length = 0};
    lx_decode_can(self, &event->frame, &text);
    self->line(self->ctx, event->at, event->ours, text.text);
}

static void on_levels(struct lx_decoder *self, const struct dg_tap_event *event)
{
    (void)self;
    (void)event;
}

static void on_words(struct lx_decoder *self, const struct dg_tap_event *event)
{
    struct lx_text text = {.length = 0};
    if (lx_decode_words(self, event, &text)) {
        self->line(self->ctx, event->at, event->ours, text.text);
    }
}

static void on_note(struct lx_decoder *self, const struct dg_tap_event *event)
{
    struct lx_text text = {.length = 0};
    lx_text_add(&text, "%s", event->note);
    self->line(self->ctx, event->at, event->ours, text.text);
}

void lx_decoder_event(struct lx_decoder *self, const struct dg_tap_event *event)
{
    static void (*const events[])(struct lx_decoder *, const struct dg_tap_event *) = {
        [DG_TAP_CHARACTER] = on_character, [DG_TAP_FRAME] = on_frame, [DG_TAP_LEVELS] = on_levels,
        [DG_TAP_WORDS] = on_words,         [DG_TAP_NOTE] = on_note,
    };
    events[event->kind](self, event);
}

dg_ns lx_decoder_step(struct lx_decoder *self, dg_ns now)
{
    if (self->length > 0 && wait_end(self) <= now) {
        give_frame(self);
    }
    return self->length > 0 ? wait_end(self) : DG_NEVER;
}
