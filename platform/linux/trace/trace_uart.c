/* SPDX-License-Identifier: MIT */
/*
 * RS485 as the level of the line, that of requests and that of replies. A frame is drawn when it is
 * over and its text is known:
 *
 *   text     |40h_42h_read_position         |  |40h_->_42h_position_12345 ...
 *   request  |_0000001~|_0100001~|_0100000~|~~~~~~~~~~~~~~~~~~~~~~             idle is high
 *   reply    ~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~|_0000001~|_0100001~| ...
 *
 * Characters are known by their end. Those that a pty hands over in a bunch have the same end; they
 * are drawn one after the other, the last of them ending then, as they would have come in.
 *
 * Sine and cosine come in while a frame is collected that begins before them: they wait for it.
 */
#include <string.h>

#include "drehgeber/bits.h"
#include "trace_format.h"
#include "uart.h"

/* Steps of a file: a bit has BIT_STEPS of them at least, unless it is too short for that. */
#define STEP_MAX DG_US(1)
#define STEP_MIN 10u
#define BIT_STEPS 20u
#define DATA_BITS 8u
/* Characters under one text; more are drawn before it is known. */
#define FRAME_MAX 140u
/* A character that is told now may have begun this much before: 11 bits at 600 Bd. Notes wait as
 * long, for it. */
#define CHARACTER_MAX DG_MS(20)
/* More than this behind its time a character is not drawn: a flood that no line could carry. */
#define BEHIND_MAX DG_S(1)
/* A damaged character without parity: its stop bit is low for three quarters. */
#define QUARTERS 4u
/* Samples that wait: the longest frame at 600 Bd, one encoder, one every 150 us. More are left out.
 */
#define SAMPLES_MAX 16384u

/* Who talks. */
enum side {
    SIDE_MASTER,
    SIDE_ENCODER,
    SIDE_COUNT,
};
static const char side_ids[SIDE_COUNT + 1] = {[SIDE_MASTER] = 'q', [SIDE_ENCODER] = 'a'};

struct character {
    dg_ns end; /* since the trace began */
    uint32_t baud;
    enum side side;
    char parity;
    uint8_t byte;
    bool damaged;
};

/* Sine and cosine of an encoder that wait for their turn. */
struct sample {
    dg_ns at;
    size_t encoder;
    int32_t uv[LX_VCD_SINCOS];
};

struct uart {
    struct lx_vcd vcd;
    struct dg_words_wire words;
    bool levels[SIDE_COUNT];
    dg_ns free; /* end of the character drawn last */
    size_t count;
    struct character frame[FRAME_MAX];
    struct character latest; /* the one that is being told, */
    bool apart;              /* ... unless it is in `frame` */
    size_t first_sample;
    size_t sample_count;
    struct sample samples[SAMPLES_MAX];
};

static dg_ns duration(const struct character *character)
{
    return dg_bit_times_ns(lx_character_bits(character->parity), character->baud);
}

/* All samples and texts up to `at`. */
static void advance_line(struct uart *self, dg_ns at)
{
    while (self->sample_count > 0 && self->samples[self->first_sample].at <= at) {
        const struct sample *sample = &self->samples[self->first_sample];
        lx_vcd_sincos(&self->vcd, sample->at, sample->encoder, sample->uv);
        self->first_sample = (self->first_sample + 1u) % SAMPLES_MAX;
        self->sample_count--;
    }
    lx_vcd_advance(&self->vcd, at);
}

static void draw_level(struct uart *self, enum side side, dg_ns at, bool level)
{
    if (level != self->levels[side]) {
        advance_line(self, at);
        lx_vcd_level(&self->vcd, at, side_ids[side], level);
        self->levels[side] = level;
    }
}

/* Damage is where a receiver finds it: in the parity, or in the stop bit. */
static void draw_character(struct uart *self, const struct character *character, dg_ns start)
{
    const uint32_t baud = character->baud;
    const enum side side = character->side;
    draw_level(self, side, start, false);
    for (unsigned i = 0; i < DATA_BITS; i++) {
        draw_level(self, side, start + dg_bit_times_ns(1u + i, baud),
                   (character->byte >> i & 1u) != 0);
    }
    dg_ns stop = start + dg_bit_times_ns(1u + DATA_BITS, baud);
    if (character->parity != 'N') {
        const bool odd = (character->parity == 'O') != character->damaged;
        draw_level(self, side, stop, (__builtin_parity(character->byte) != 0) != odd);
        stop = start + dg_bit_times_ns(2u + DATA_BITS, baud);
    } else if (character->damaged) {
        draw_level(self, side, stop, false);
        stop += dg_bit_times_ns(1, baud) / QUARTERS * (QUARTERS - 1u);
    }
    draw_level(self, side, stop, true);
}

/* Ends that are possible on a line, from the last one back. */
static void spread_ends(struct uart *self)
{
    for (size_t i = self->count; i > 1; i--) {
        const struct character *next = &self->frame[i - 1];
        const dg_ns latest = dg_elapsed(next->end, duration(next));
        self->frame[i - 2].end = dg_earliest(self->frame[i - 2].end, latest);
    }
}

/* Not before the end of the one that was drawn last, nor back in the file's time. */
static dg_ns start_of(const struct uart *self, const struct character *character)
{
    const dg_ns start = dg_elapsed(character->end, duration(character));
    const dg_ns least = self->free > self->vcd.at ? self->free : self->vcd.at;
    return start > least ? start : least;
}

/* What was collected, under its text; NULL: it has none. */
static void draw_frame(struct uart *self, const char *text)
{
    spread_ends(self);
    if (self->count > 0 && text != NULL) {
        lx_vcd_text(&self->vcd, start_of(self, &self->frame[0]), text);
    }
    for (size_t i = 0; i < self->count; i++) {
        const struct character *character = &self->frame[i];
        const dg_ns start = start_of(self, character);
        if (dg_elapsed(start, character->end) < BEHIND_MAX) {
            draw_character(self, character, start);
            self->free = start + duration(character);
        }
    }
    if (text != NULL) {
        lx_vcd_text(&self->vcd, self->free, "");
    }
    advance_line(self, self->free);
    self->count = 0;
}

/* One more; `latest` is in a frame then. */
static void collect_frame(struct uart *self)
{
    if (self->apart && self->count == FRAME_MAX) {
        draw_frame(self, "too long");
    }
    if (self->apart) {
        self->frame[self->count++] = self->latest;
        self->apart = false;
    }
}

static void on_line(void *ctx, const struct dg_words_line *line)
{
    struct uart *self = ctx;
    if (line->whole) {
        collect_frame(self);
    }
    draw_frame(self, line->text);
}

/* 1 us up to 50 kBd, a power of ten. */
static dg_ns time_step_of(const struct lx_tap *tap)
{
    dg_ns step = STEP_MAX;
    while (tap->baud > 0 && step > STEP_MIN && dg_bit_times_ns(1, tap->baud) < BIT_STEPS * step) {
        step /= 10u;
    }
    return step;
}

static void uart_begin(struct lx_trace *self)
{
    const struct lx_vcd_head head = {
        "rs485", time_step_of(self->tap), side_ids, {"request", "reply"}};
    struct uart *uart = self->own;
    for (size_t i = 0; i < SIDE_COUNT; i++) {
        uart->levels[i] = true;
    }
    uart->words = (struct dg_words_wire){self->words, self->memory, {on_line, uart}};
    lx_vcd_begin(&uart->vcd, self, &head);
}

static void on_character(struct uart *self, const struct dg_tap_event *event, dg_ns at)
{
    if (event->character.baud == 0) {
        return;
    }
    self->latest = (struct character){
        .end = at,
        .baud = event->character.baud,
        .side = event->ours ? SIDE_ENCODER : SIDE_MASTER,
        .parity = event->character.parity,
        .byte = event->character.byte,
        .damaged = event->character.damaged,
    };
    self->apart = true;
    dg_words_event(&self->words, event);
    collect_frame(self);
    if (self->words.words == NULL) { /* then nobody says where a frame ends */
        draw_frame(self, NULL);
    }
}

static void on_sample(struct uart *self, const struct dg_tap_event *event, dg_ns at)
{
    if (self->sample_count < SAMPLES_MAX) {
        const size_t place = (self->first_sample + self->sample_count) % SAMPLES_MAX;
        self->samples[place] = (struct sample){.at = at, .encoder = event->sincos.encoder};
        memcpy(self->samples[place].uv, event->sincos.uv, sizeof event->sincos.uv);
        self->sample_count++;
    }
}

static void uart_event(struct lx_trace *self, const struct dg_tap_event *event)
{
    struct uart *uart = self->own;
    const dg_ns at = dg_elapsed(event->at, self->opened);
    (void)dg_words_step(&uart->words, event->at);
    if (uart->count == 0) {
        advance_line(uart, dg_elapsed(at, CHARACTER_MAX));
    }
    if (event->kind == DG_TAP_CHARACTER) {
        on_character(uart, event, at);
    } else if (event->kind == DG_TAP_NOTE) {
        lx_vcd_text(&uart->vcd, at, event->note);
    } else if (event->kind == DG_TAP_SINCOS) {
        on_sample(uart, event, at);
    }
}

static void uart_end(struct lx_trace *self)
{
    struct uart *uart = self->own;
    (void)dg_words_step(&uart->words, DG_NEVER);
    advance_line(uart, DG_NEVER);
    lx_vcd_end(&uart->vcd);
}

const struct lx_trace_format lx_trace_uart = {
    .ending = ".vcd",
    .mark = LX_VCD_MARK,
    .size = sizeof(struct uart),
    .begin = uart_begin,
    .event = uart_event,
    .end = uart_end,
};
