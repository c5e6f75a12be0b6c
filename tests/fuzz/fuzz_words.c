/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: all words on hostile wires. The input is a stream of events of every kind, at any
 * time; each goes over the wire of every protocol, and of one without words. Lines are text that
 * fits, and none is told without an event.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/words.h"
#include "fuzz_input.h"

#define WORDS 600u /* more than those of a ring remember */
#define WIRES_MAX 8u
#define MEMORY 4096u

/* A wire, and how many lines it has told. */
struct told {
    struct dg_words_wire wire;
    unsigned lines;
    union {
        max_align_t align;
        unsigned char bytes[MEMORY];
    } memory;
};

static void on_line(void *ctx, const struct dg_words_line *line)
{
    struct told *self = ctx;
    const size_t n = strlen(line->text);

    fuzz_must(n > 0 && n < DG_WORDS_MAX);
    fuzz_must(line->severity < DG_SEVERITY_COUNT);
    self->lines++;
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
    static uint8_t widths[WORDS];
    static uint16_t words[2][WORDS];
    const uint32_t where = fuzz_take32(input);

    words[where & 1u][(where >> 1) % WORDS] = (uint16_t)(where >> 16);
    for (size_t i = 0; i < WORDS; i++) {
        widths[i] = (uint8_t)(1u + i % 2u);
    }
    event->kind = DG_TAP_WORDS;
    event->words.widths = (where & 2u) != 0 ? widths : NULL;
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

static void report_event(struct told *self, const struct dg_tap_event *event)
{
    const unsigned before = self->lines;

    dg_words_event(&self->wire, event);
    fuzz_must(self->lines <= before + 2u);
    const dg_ns next = dg_words_step(&self->wire, event->at);
    fuzz_must(next > event->at || event->at == DG_NEVER);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct dg_tap_event *, struct fuzz_input *) = {
        op_character, op_character, op_character, op_frame, op_sdo, op_words, op_note, op_levels,
    };
    static struct told told[WIRES_MAX];
    struct fuzz_input input = {.at = bytes, .end = bytes + n};
    dg_ns now = 0;

    fuzz_must(dg_words_count < WIRES_MAX);
    memset(told, 0, sizeof told);
    for (size_t i = 0; i <= dg_words_count; i++) {
        const struct dg_words *words = i < dg_words_count ? dg_words_list[i] : NULL;
        fuzz_must(words == NULL || words->size <= MEMORY);
        told[i].wire = (struct dg_words_wire){words, &told[i].memory, {on_line, &told[i]}};
    }
    while (input.at < input.end) {
        const uint8_t how = fuzz_take(&input);
        struct dg_tap_event event = {.ours = (how & 1u) != 0};
        now = dg_after(now, (dg_ns)(how >> 4) << (how >> 4) * 3u);
        event.at = now;
        operations[(how >> 1) & 7u](&event, &input);
        for (size_t i = 0; i <= dg_words_count; i++) {
            report_event(&told[i], &event);
        }
    }
    for (size_t i = 0; i <= dg_words_count; i++) {
        (void)dg_words_step(&told[i].wire, DG_NEVER);
        fuzz_must(dg_words_step(&told[i].wire, DG_NEVER) == DG_NEVER);
    }
    return 0;
}
