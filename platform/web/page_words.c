/* SPDX-License-Identifier: MIT */
/*
 * What goes over a wire, in the words of the command's --verbose: events of a handle become events
 * of a tap, and the words of its protocol make lines of them. A ring is that of the library, whose
 * tap it is.
 */
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/devices.h"
#include "drehgeber/host.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/words.h"

/* The page's: a line of text, with its zero, of what began at `at`. */
void web_line(void *ctx, dg_ns at, bool ours, enum dg_severity severity, const char *text)
    __attribute__((import_module("page"), import_name("line")));

/* The wire of an encoder, and what its words remember of it. */
struct web_words {
    struct dg_words_wire wire;
    max_align_t memory[];
};

size_t web_words_size(const struct dg_device *device);
void web_words_init(struct web_words *self, const struct dg_device *device);
void web_words_step(struct web_words *self, uint64_t now);
void web_words_uart(struct web_words *self, const struct dg_host_event *event, bool ours,
                    const struct dg_host_uart *uart);
void web_words_can(struct web_words *self, const struct dg_host_event *event, bool ours);

/* A ring of one encoder. */
struct web_ring {
    struct web_words *words;
    struct dg_bus *bus;
    uint16_t in[DG_RING_WORDS_MAX];
    _Alignas(DG_HOST_ALIGN) uint8_t memory[];
};

size_t web_ring_size(void);
void web_ring_init(struct web_ring *self, struct web_words *words, struct dg_host *host,
                   struct dg_host_panel *panel);
/* A data cycle, which words tell if it is `told`. @return whether it brought data */
bool web_ring_cycle(const struct web_ring *self, uint64_t now, uint32_t out, bool told);
/* @return the ID word of the encoder; -1: the ID cycle has not reached it */
int web_ring_identify(const struct web_ring *self, uint64_t now);
/* The bytes of IN, the high one first. @return how many, at most 2 * DG_RING_WORDS_MAX */
size_t web_ring_in(const struct web_ring *self, uint8_t *to);

static void tell_line(void *ctx, const struct dg_words_line *line)
{
    web_line(ctx, line->at, line->ours, line->severity, line->text);
}

size_t web_words_size(const struct dg_device *device)
{
    const struct dg_words *words = dg_words_of(device->stack);

    return sizeof(struct web_words) + (words == NULL ? 0 : words->size);
}

void web_words_init(struct web_words *self, const struct dg_device *device)
{
    memset(self, 0, web_words_size(device));
    self->wire =
        (struct dg_words_wire){dg_words_of(device->stack), self->memory, {tell_line, self}};
}

void web_words_step(struct web_words *self, uint64_t now)
{
    (void)dg_words_step(&self->wire, now);
}

void web_words_uart(struct web_words *self, const struct dg_host_event *event, bool ours,
                    const struct dg_host_uart *uart)
{
    struct dg_tap_event tap = {.kind = DG_TAP_CHARACTER, .ours = ours};

    tap.character.baud = uart->baud;
    tap.character.parity = (char)uart->parity;
    tap.character.damaged = (event->flags & DG_HOST_DAMAGED) != 0;
    for (size_t i = 0; i < event->length; i++) {
        tap.at = dg_after(event->at, (dg_ns)(i + 1u) * event->id);
        tap.character.byte = event->data[i];
        dg_words_event(&self->wire, &tap);
    }
}

void web_words_can(struct web_words *self, const struct dg_host_event *event, bool ours)
{
    struct dg_tap_event tap = {.kind = DG_TAP_FRAME, .at = event->at, .ours = ours};

    tap.frame.id = (uint16_t)event->id;
    tap.frame.rtr = (event->flags & DG_HOST_REMOTE) != 0;
    tap.frame.dlc = event->length;
    memcpy(tap.frame.data, event->data, sizeof tap.frame.data);
    dg_words_event(&self->wire, &tap);
}

/* ------------------------------------------------------------ a ring */

static void tell_cycle(void *ctx, const struct dg_tap_event *event)
{
    const struct web_ring *self = ctx;

    dg_words_event(&self->words->wire, event);
}

size_t web_ring_size(void)
{
    return sizeof(struct web_ring) + dg_bus_size(&dg_bus_words, 1);
}

void web_ring_init(struct web_ring *self, struct web_words *words, struct dg_host *host,
                   struct dg_host_panel *panel)
{
    static const struct dg_bus_ops ops = {.tap = tell_cycle};
    const struct dg_bus_words_setup wire = {sizeof wire, self->in, DG_COUNT(self->in), true};
    const struct dg_bus_setup setup = {sizeof setup, &dg_bus_words, 1, &wire, &ops, self};

    self->words = words;
    self->bus = dg_bus_init(self->memory, dg_bus_size(&dg_bus_words, 1), &setup);
    (void)dg_bus_attach(self->bus, host, dg_host_panel_encoder(panel));
}

/* `out` NULL: an ID cycle. The page may have done anything to the encoder since the last one. */
static const struct dg_ring_state *run_cycle(const struct web_ring *self, uint64_t now,
                                             const uint16_t *out)
{
    const struct dg_ring_state *is = dg_ring_state(self->bus);
    const struct dg_tap_event event = {
        .at = now,
        .kind = DG_TAP_WORDS,
        .ours = true,
        .words = {.out = out, .count = is->words, .identify = out == NULL},
    };

    (void)dg_bus_changed(self->bus, 0, now);
    (void)dg_bus_rx(self->bus, &event);
    return is;
}

bool web_ring_cycle(const struct web_ring *self, uint64_t now, uint32_t out, bool told)
{
    const uint16_t high_first[] = {(uint16_t)(out >> 16), (uint16_t)out};
    const struct dg_ring_state *is = dg_ring_state(self->bus);
    const uint16_t *words = high_first + DG_COUNT(high_first) - is->words;

    dg_bus_watch(self->bus, told);
    (void)run_cycle(self, now, words);
    if (is->result == DG_RING_IDENTIFY && !is->dropped) {
        (void)run_cycle(self, now, words); /* the ring has run an ID cycle */
    }
    return is->result == DG_RING_OK && !is->dropped;
}

int web_ring_identify(const struct web_ring *self, uint64_t now)
{
    dg_bus_watch(self->bus, false); /* the page tells what comes of it */
    const struct dg_ring_state *is = run_cycle(self, now, NULL);

    return is->reached > 0 && !is->dropped ? dg_ring_id_word(self->bus, 0) : -1;
}

size_t web_ring_in(const struct web_ring *self, uint8_t *to)
{
    const size_t count = dg_ring_state(self->bus)->words;

    for (size_t i = 0; i < count; i++) {
        to[2u * i] = (uint8_t)(self->in[i] >> 8);
        to[2u * i + 1u] = (uint8_t)self->in[i];
    }
    return 2u * count;
}
