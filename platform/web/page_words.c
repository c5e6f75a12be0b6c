/* SPDX-License-Identifier: MIT */
/*
 * What goes over a wire, in the words of the command's --verbose: events of a handle become events
 * of a tap, and the words of its protocol make lines of them.
 */
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "drehgeber/host.h"
#include "drehgeber/words.h"

#define WORDS_MAX 8u

/* The page's: a line of text, with its zero, of what began at `at`. */
void web_line(void *ctx, dg_ns at, bool ours, enum dg_severity severity, const char *text)
    __attribute__((import_module("page"), import_name("line")));

/* The wire of an encoder, and what its words remember of it. */
struct web_words {
    struct dg_words_wire wire;
    max_align_t memory[];
};

size_t web_words_size(const char *model);
void web_words_init(struct web_words *self, const char *model);
void web_words_step(struct web_words *self, uint64_t now);
void web_words_uart(struct web_words *self, const struct dg_host_event *event, bool ours,
                    const struct dg_host_uart *uart);
void web_words_can(struct web_words *self, const struct dg_host_event *event, bool ours);
void web_words_cycle(struct web_words *self, const struct dg_host_event *out,
                     const struct dg_host_event *in);

static const struct dg_words *words_of(const char *model)
{
    const struct dg_device *device = dg_device_find(model);

    return device == NULL ? NULL : dg_words_of(device->stack);
}

static void tell_line(void *ctx, const struct dg_words_line *line)
{
    web_line(ctx, line->at, line->ours, line->severity, line->text);
}

size_t web_words_size(const char *model)
{
    const struct dg_words *words = words_of(model);

    return sizeof(struct web_words) + (words == NULL ? 0 : words->size);
}

void web_words_init(struct web_words *self, const char *model)
{
    memset(self, 0, web_words_size(model));
    self->wire = (struct dg_words_wire){words_of(model), self->memory, {tell_line, self}};
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

/* The high word first; OUT is as wide as IN. */
void web_words_cycle(struct web_words *self, const struct dg_host_event *out,
                     const struct dg_host_event *in)
{
    uint16_t ins[WORDS_MAX];
    uint16_t outs[WORDS_MAX];
    const uint16_t count = (uint16_t)(in->length / 2u);
    const uint8_t width = (uint8_t)count;
    struct dg_tap_event tap = {.kind = DG_TAP_WORDS, .at = in->at, .ours = true};

    for (unsigned i = 0; i < count; i++) {
        ins[i] = (uint16_t)((unsigned)in->data[2u * i] << 8 | in->data[2u * i + 1u]);
        outs[i] = (uint16_t)(out->id >> 16u * (count - 1u - i));
    }
    tap.words.in = ins;
    tap.words.out = outs;
    tap.words.widths = &width;
    tap.words.count = count;
    tap.words.valid = true;
    dg_words_event(&self->wire, &tap);
}
