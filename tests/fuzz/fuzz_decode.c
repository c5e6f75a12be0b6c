/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: the decoder on hostile wires. The input is a stream of events of every kind, for
 * every stack, at any time. Lines are text that fits, and none is given without an event.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "fuzz_input.h"
#include "trace.h"

#define WORDS 600u /* more than the decoder keeps */

static unsigned lines;

static void on_line(void *ctx, dg_ns at, bool ours, const char *text)
{
    const size_t n = strlen(text);

    (void)ctx;
    (void)at;
    (void)ours;
    fuzz_must(n > 0 && n < LX_DECODE_MAX);
    lines++;
}

static void op_character(struct dg_tap_event *event, struct fuzz_input *input)
{
    static const uint32_t bauds[] = {600, 9600, 38400, 0};
    const uint8_t how = fuzz_take(input);

    event->kind = DG_TAP_CHARACTER;
    event->character.baud = bauds[how & 3u];
    event->character.parity = "NEO"[(how >> 2) % 3u];
    event->character.damaged = how > 0xF0;
    event->character.byte = fuzz_take(input);
}

static void op_frame(struct dg_tap_event *event, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    event->kind = DG_TAP_FRAME;
    event->frame.id = (uint16_t)fuzz_take32(input);
    event->frame.rtr = (how & 0xF0u) == 0xF0u;
    event->frame.dlc = (how & 0x10u) != 0 ? how & 0x0Fu : 8;
    for (size_t i = 0; i < sizeof event->frame.data; i++) {
        event->frame.data[i] = fuzz_take(input);
    }
}

/* Those of one node, which remember what came before. */
static void op_sdo(struct dg_tap_event *event, struct fuzz_input *input)
{
    op_frame(event, input);
    event->frame.id = event->ours ? 0x585 : 0x605;
    event->frame.dlc = 8;
}

static void op_words(struct dg_tap_event *event, struct fuzz_input *input)
{
    static uint16_t words[2][WORDS];
    const uint32_t where = fuzz_take32(input);

    words[where & 1u][(where >> 1) % WORDS] = (uint16_t)(where >> 16);
    event->kind = DG_TAP_WORDS;
    event->words.in = words[0];
    event->words.out = words[1];
    event->words.count = (uint16_t)(fuzz_take(input) < 8 ? where % WORDS : 5);
    event->words.valid = fuzz_take(input) < 0xF0;
}

static void op_note(struct dg_tap_event *event, struct fuzz_input *input)
{
    static char note[512];
    const size_t n = 1u + 2u * fuzz_take(input);

    memset(note, 'n', n);
    note[n] = '\0';
    event->kind = DG_TAP_NOTE;
    event->note = note;
}

static void op_levels(struct dg_tap_event *event, struct fuzz_input *input)
{
    event->kind = DG_TAP_LEVELS;
    event->levels.clock = fuzz_take(input) != 0;
    event->levels.data = event->levels.clock;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct dg_tap_event *, struct fuzz_input *) = {
        op_character, op_character, op_character, op_frame, op_sdo, op_words, op_note, op_levels,
    };
    struct fuzz_input input = {.at = bytes, .end = bytes + n};
    struct lx_decoder decoder;
    dg_ns now = 0;

    lx_decoder_init(&decoder, on_line, NULL);
    while (input.at < input.end) {
        const uint8_t how = fuzz_take(&input);
        struct dg_tap_event event = {.ours = (how & 1u) != 0};
        const unsigned before = lines;
        now = dg_after(now, (dg_ns)(how >> 4) << (how >> 4) * 3u);
        event.at = now;
        operations[(how >> 1) & 7u](&event, &input);
        lx_decoder_event(&decoder, &event);
        fuzz_must(lines <= before + 2u);
        fuzz_must(lx_decoder_step(&decoder, now) > now || now == DG_NEVER);
    }
    (void)lx_decoder_step(&decoder, DG_NEVER);
    fuzz_must(decoder.length == 0);
    return 0;
}
