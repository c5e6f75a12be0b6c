/* SPDX-License-Identifier: MIT */
/*
 * What goes over a wire, in the words of the command's --verbose: events of a handle become events
 * of a tap, and the decoder of the traces makes lines of them.
 */
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/host.h"
#include "trace.h"

#define WORDS_MAX 8u

/* The page's: a line of text, with its zero, of what began at `at`. */
void web_line(void *ctx, dg_ns at, bool ours, const char *text)
    __attribute__((import_module("page"), import_name("line")));

size_t web_words_size(void);
void web_words_init(struct lx_decoder *self);
void web_words_step(struct lx_decoder *self, uint64_t now);
void web_words_uart(struct lx_decoder *self, const struct dg_host_event *event, bool ours,
                    const struct dg_host_uart *uart);
void web_words_can(struct lx_decoder *self, const struct dg_host_event *event, bool ours);
void web_words_cycle(struct lx_decoder *self, const struct dg_host_event *out,
                     const struct dg_host_event *in);

size_t web_words_size(void)
{
    return sizeof(struct lx_decoder);
}

void web_words_init(struct lx_decoder *self)
{
    lx_decoder_init(self, web_line, self);
}

void web_words_step(struct lx_decoder *self, uint64_t now)
{
    (void)lx_decoder_step(self, now);
}

void web_words_uart(struct lx_decoder *self, const struct dg_host_event *event, bool ours,
                    const struct dg_host_uart *uart)
{
    struct dg_tap_event tap = {.kind = DG_TAP_CHARACTER, .ours = ours};

    tap.character.baud = uart->baud;
    tap.character.parity = (char)uart->parity;
    tap.character.damaged = (event->flags & DG_HOST_DAMAGED) != 0;
    for (size_t i = 0; i < event->length; i++) {
        tap.at = dg_after(event->at, (dg_ns)(i + 1u) * event->id);
        tap.character.byte = event->data[i];
        lx_decoder_event(self, &tap);
    }
}

void web_words_can(struct lx_decoder *self, const struct dg_host_event *event, bool ours)
{
    struct dg_tap_event tap = {.kind = DG_TAP_FRAME, .at = event->at, .ours = ours};

    tap.frame.id = (uint16_t)event->id;
    tap.frame.rtr = (event->flags & DG_HOST_REMOTE) != 0;
    tap.frame.dlc = event->length;
    memcpy(tap.frame.data, event->data, sizeof tap.frame.data);
    lx_decoder_event(self, &tap);
}

/* The high word first; OUT is as wide as IN. */
void web_words_cycle(struct lx_decoder *self, const struct dg_host_event *out,
                     const struct dg_host_event *in)
{
    uint16_t ins[WORDS_MAX];
    uint16_t outs[WORDS_MAX];
    const uint16_t count = (uint16_t)(in->length / 2u);
    struct dg_tap_event tap = {.kind = DG_TAP_WORDS, .at = in->at, .ours = true};

    for (unsigned i = 0; i < count; i++) {
        ins[i] = (uint16_t)((unsigned)in->data[2u * i] << 8 | in->data[2u * i + 1u]);
        outs[i] = (uint16_t)(out->id >> 16u * (count - 1u - i));
    }
    tap.words.in = ins;
    tap.words.out = outs;
    tap.words.count = count;
    tap.words.valid = true;
    lx_decoder_event(self, &tap);
}
