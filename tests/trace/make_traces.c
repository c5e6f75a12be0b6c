/* SPDX-License-Identifier: MIT */
/*
 * Trace files from events on stdin, a line for each:
 *
 *   c NS OURS BAUD PARITY BYTE DAMAGED      f NS OURS ID RTR DLC BYTE...     l NS MA SLO
 *   w NS VALID COUNT IN... OUT...           n NS OURS TEXT
 *
 * usage: make_traces rs485|biss|can|interbus WIRE FILE
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "can_bus.h"
#include "stacks.h"
#include "trace.h"

#define WORDS_MAX 512u

/* What events point to. */
struct room {
    uint16_t in[WORDS_MAX];
    uint16_t out[WORDS_MAX];
};

static const struct {
    const char *name;
    const struct lx_stack *stack;
} stacks[] = {
    {"rs485", &lx_hf_stack},
    {"biss", &lx_biss_stack},
    {"can", &lx_cia406_stack},
    {"interbus", &lx_ib_stack},
};

/* The next number of the line; there must be one. */
static uint64_t number(int base)
{
    const char *word = strtok(NULL, " \n");
    if (word == NULL) {
        (void)fputs("make_traces: a line is too short\n", stderr);
        exit(1);
    }
    return strtoull(word, NULL, base);
}

static void take_character(struct dg_tap_event *event, struct room *room)
{
    (void)room;
    event->kind = DG_TAP_CHARACTER;
    event->ours = number(10) != 0;
    event->character.baud = (uint32_t)number(10);
    event->character.parity = strtok(NULL, " \n")[0];
    event->character.byte = (uint8_t)number(16);
    event->character.damaged = number(10) != 0;
}

static void take_frame(struct dg_tap_event *event, struct room *room)
{
    (void)room;
    event->kind = DG_TAP_FRAME;
    event->ours = number(10) != 0;
    event->frame = (struct dg_can_frame){.id = (uint16_t)number(16)};
    event->frame.rtr = number(10) != 0;
    event->frame.dlc = (uint8_t)number(10);
    for (uint8_t i = 0; !event->frame.rtr && i < event->frame.dlc; i++) {
        event->frame.data[i] = (uint8_t)number(16);
    }
}

static void take_levels(struct dg_tap_event *event, struct room *room)
{
    (void)room;
    event->kind = DG_TAP_LEVELS;
    event->levels.clock = number(10) != 0;
    event->levels.data = number(10) != 0;
}

static void take_words(struct dg_tap_event *event, struct room *room)
{
    event->kind = DG_TAP_WORDS;
    event->words.valid = number(10) != 0;
    event->words.count = (uint16_t)(number(10) % (WORDS_MAX + 1u));
    event->words.in = room->in;
    event->words.out = room->out;
    for (uint16_t i = 0; i < event->words.count; i++) {
        room->in[i] = (uint16_t)number(16);
    }
    for (uint16_t i = 0; i < event->words.count; i++) {
        room->out[i] = (uint16_t)number(16);
    }
}

static void take_note(struct dg_tap_event *event, struct room *room)
{
    (void)room;
    event->kind = DG_TAP_NOTE;
    event->ours = number(10) != 0;
    event->note = strtok(NULL, "\n");
}

static void feed_line(const struct lx_tap *tap, char *line)
{
    static const struct {
        char letter;
        void (*take)(struct dg_tap_event *event, struct room *room);
    } kinds[] = {
        {'c', take_character}, {'f', take_frame}, {'l', take_levels},
        {'w', take_words},     {'n', take_note},
    };
    static struct room room;
    const char *word = strtok(line, " \n");
    for (size_t i = 0; word != NULL && i < DG_COUNT(kinds); i++) {
        if (kinds[i].letter == word[0]) {
            struct dg_tap_event event = {.at = number(10)};
            kinds[i].take(&event, &room);
            lx_tap_tell(tap, &event);
        }
    }
}

int main(int argc, char *argv[])
{
    struct lx_tap tap = {.first = NULL};
    struct lx_error error;
    char line[8192];
    size_t stack = 0;
    while (argc == 4 && stack < DG_COUNT(stacks) && strcmp(stacks[stack].name, argv[1]) != 0) {
        stack++;
    }
    if (argc != 4 || stack == DG_COUNT(stacks)) {
        (void)fputs("usage: make_traces rs485|biss|can|interbus WIRE FILE\n", stderr);
        return 2;
    }
    const struct lx_trace_setup setup = {
        .path = argv[3],
        .kind = stacks[stack].stack->trace,
        .words = dg_words_of(stacks[stack].stack->core),
        .wire = argv[2],
        .tap = &tap,
    };
    struct lx_trace *trace = lx_trace_open(&setup, 0, &error);
    while (trace != NULL && fgets(line, sizeof line, stdin) != NULL) {
        feed_line(&tap, line);
    }
    if (trace == NULL || lx_trace_close(trace, &error) != 0) {
        (void)fprintf(stderr, "make_traces: %s\n", lx_error_line(&error).text);
        return 1;
    }
    return 0;
}
