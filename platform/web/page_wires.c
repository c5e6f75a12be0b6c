/* SPDX-License-Identifier: MIT */
/*
 * Both ends of the wires: what goes over one becomes lines, in the words of --verbose, and
 * levels; what the masters of the page ask goes to its bus.
 */
#include <string.h>

#include "drehgeber/host_wire.h"
#include "page.h"

/* The page's: a line of text, with its zero, of what began at `at`. */
void web_line(const struct web_wire *wire, dg_ns at, bool ours, enum dg_severity severity,
              const char *text) __attribute__((import_module("page"), import_name("line")));
/* Of a clocked wire: data is at `level` from `at` on. */
void web_level(const struct web_wire *wire, dg_ns at, bool level)
    __attribute__((import_module("page"), import_name("level")));

/* Characters: a request, behind those that are on the line. @return when it is over */
dg_ns web_request(const struct web_encoder *self, dg_ns now, const uint8_t *bytes, size_t n);
/* Frames: one of up to 8 bytes. */
void web_frame(const struct web_encoder *self, dg_ns now, uint32_t id, const uint8_t *bytes,
               size_t n);
/* A ring: a data cycle with the OUT word of this encoder, which is told if it is `told`; `to`: its
 * bytes of IN, the high one first. @return how many, at most 2 * DG_RING_WORDS_MAX; -1: it has
 * brought no data */
int web_cycle(const struct web_encoder *self, dg_ns now, uint32_t out, bool told, uint8_t *to);
/* A ring: an ID cycle. @return the ID word of this encoder; -1: the cycle has not reached it */
int web_identify(const struct web_encoder *self, dg_ns now);

/* ------------------------------------------------------------ what is heard */

static void tell_line(void *ctx, const struct dg_words_line *line)
{
    struct web_wire *self = ctx;
    struct web_said *said = &self->said[line->ours];

    self->bytes = said->bytes;
    self->count = said->count;
    said->count = 0;
    web_line(self, line->at, line->ours, line->severity, line->text);
}

static void keep_byte(struct web_said *self, unsigned byte)
{
    if (self->count < WEB_SAID_MAX) {
        self->bytes[self->count++] = (uint8_t)byte;
    }
}

static void keep_words(struct web_said *self, const uint16_t *words, size_t count)
{
    self->count = 0; /* the image as it is */
    for (size_t i = 0; i < count; i++) {
        keep_byte(self, words[i] >> 8);
        keep_byte(self, words[i]);
    }
}

static void look_at_wire(void *ctx, const struct dg_tap_event *event)
{
    struct web_wire *self = ctx;
    struct web_said *said = &self->said[event->ours];

    if (event->kind == DG_TAP_CHARACTER) {
        keep_byte(said, event->character.byte);
    } else if (event->kind == DG_TAP_WORDS) {
        keep_words(said, event->words.in, event->words.count);
    }
    for (uint8_t i = 0; event->kind == DG_TAP_FRAME && i < event->frame.dlc; i++) {
        keep_byte(said, event->frame.data[i]);
    }
    dg_words_event(&self->words, event);
}

static void hear_nothing(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    (void)event;
}

static void hear_level(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)place;
    web_level(ctx, event->at, event->levels.data);
}

const struct dg_bus_ops *web_wire_ops(enum dg_medium medium)
{
    static const struct dg_bus_ops told = {.tx = hear_nothing, .tap = look_at_wire};
    static const struct dg_bus_ops clocked = {.tx = hear_level};

    return medium == DG_MEDIUM_EDGES ? &clocked : &told;
}

void web_wire_init(struct web_wire *self, const struct dg_words *words, void *memory)
{
    self->words = (struct dg_words_wire){words, memory, {tell_line, self}};
}

/* ------------------------------------------------------------ what is asked */

dg_ns web_request(const struct web_encoder *self, dg_ns now, const uint8_t *bytes, size_t n)
{
    const struct dg_host_uart uart = dg_bus_characters_uart(self->bus, self->place);
    struct dg_tap_event event = {
        .at = now,
        .kind = DG_TAP_CHARACTER,
        .character = {.baud = uart.baud, .parity = (char)uart.parity},
    };

    for (size_t i = 0; i < n; i++) {
        event.character.byte = bytes[i];
        (void)dg_bus_rx(self->bus, &event);
    }
    return dg_after(now, dg_host_uart_ns(&uart, (uint32_t)n));
}

void web_frame(const struct web_encoder *self, dg_ns now, uint32_t id, const uint8_t *bytes,
               size_t n)
{
    struct dg_tap_event event = {.at = now, .kind = DG_TAP_FRAME};

    event.frame.id = (uint16_t)id;
    event.frame.dlc = (uint8_t)(n < sizeof event.frame.data ? n : sizeof event.frame.data);
    memcpy(event.frame.data, bytes, event.frame.dlc);
    (void)dg_bus_rx(self->bus, &event);
}

/* ------------------------------------------------------------ what is asked of a ring */

/* Words of the encoder at `place`, in either image. */
static size_t count_ring_words(const struct web_encoder *self, size_t place)
{
    struct dg_host *host = dg_bus_encoder(self->bus, place);

    return dg_host_side_at(host)->ring->words(dg_host_line_of(host));
}

/* Where those of this one begin. */
static size_t find_line_words(const struct web_encoder *self)
{
    size_t at = 0;

    for (size_t i = 0; i < self->place; i++) {
        at += count_ring_words(self, i);
    }
    return at;
}

/* `out` NULL: an ID cycle. */
static const struct dg_ring_state *run_page_cycle(const struct web_encoder *self, dg_ns now,
                                                  const uint16_t *out)
{
    const struct dg_ring_state *is = dg_ring_state(self->bus);
    const struct dg_tap_event event = {
        .at = now,
        .kind = DG_TAP_WORDS,
        .ours = true,
        .words = {.out = out, .count = is->words, .identify = out == NULL},
    };

    (void)dg_bus_rx(self->bus, &event);
    return is;
}

int web_cycle(const struct web_encoder *self, dg_ns now, uint32_t out, bool told, uint8_t *to)
{
    uint16_t *image = self->wire->out;
    const size_t at = find_line_words(self);
    const size_t end = at + count_ring_words(self, self->place);

    for (size_t i = end; i > at; i--, out >>= 16) {
        image[i - 1u] = (uint16_t)out;
    }
    dg_bus_watch(self->bus, told);
    const struct dg_ring_state *is = run_page_cycle(self, now, image);
    if (is->result == DG_RING_IDENTIFY && !is->dropped) {
        is = run_page_cycle(self, now, image); /* the ring has run an ID cycle */
    }
    for (size_t i = at; i < end; i++) {
        *to++ = (uint8_t)(self->in[i] >> 8);
        *to++ = (uint8_t)self->in[i];
    }
    return is->result == DG_RING_OK && !is->dropped ? (int)(2u * (end - at)) : -1;
}

int web_identify(const struct web_encoder *self, dg_ns now)
{
    dg_bus_watch(self->bus, false); /* the page tells what comes of it */
    const struct dg_ring_state *is = run_page_cycle(self, now, NULL);

    return is->reached > self->place && !is->dropped ? dg_ring_id_word(self->bus, self->place) : -1;
}
