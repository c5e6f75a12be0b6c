/* SPDX-License-Identifier: MIT */
/*
 * A rig file with one wire on the library's own rig at work: no event loop, no file but that one,
 * no port. Lines come in and what it says goes out as with ../rig/main.c, and two more:
 *
 *   NS cycle WORDS   a data cycle of the ring, four digits a word: "NUMBER RESULT WORDS;"
 *   NS identify      an ID cycle
 *
 * usage: differential_engine RIG.ini < LINES
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chain.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instruments.h"
#include "drehgeber/slcan.h"
#include "give_up.h"
#include "hf_rig.h"
#include "told.h"

#define LINE_CHARS_MAX 512u
#define ANSWER_MAX 32768u
#define FILE_MAX 65536u
#define WORDS_MAX 64u
/* Time of the command's rigs begins there. */
#define BEGIN DG_S(1)

static struct {
    struct dg_plan plan;
    struct dg_engine *engine;
    struct dg_bus *bus;
    struct dg_control client;
    struct dg_slcan slcan;
    struct chain chain;
    bool chained;
    dg_ns now;
    char answer[ANSWER_MAX];
} it;

/* ------------------------------------------------------------ what the wire carries */

static void hear_nothing(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    (void)event;
}

static int open_door(void *ctx, size_t index, struct dg_engine_wire *to,
                     struct dg_plan_error *error)
{
    static const struct dg_bus_ops ops = {.tx = hear_nothing, .tap = told_print};

    (void)ctx;
    (void)index;
    to->ops = &ops;
    to->frames.line = (struct dg_bus_frames_line){.closed = true, .company = DG_BUS_SOMEBODY};
    to->edges.period_ns = (uint32_t)(DG_S(1) / to->line.timing.clock_hz);
    (void)error;
    return 0;
}

/* ------------------------------------------------------------ what the master says */

static void send_characters(dg_ns now, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const struct dg_tap_event event = {
            .at = now,
            .kind = DG_TAP_CHARACTER,
            .character = {.baud = DG_BAUD_ANY, .byte = bytes[i]},
        };
        (void)dg_bus_rx(it.bus, &event);
    }
}

static void send_slcan(dg_ns now, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        struct dg_slcan_event event;
        if (!dg_slcan_feed(&it.slcan, bytes[i], &event)) {
            continue;
        }
        const struct dg_bus_frames_line line = {.bit_rate = 1000u * it.slcan.kbaud,
                                                .closed = it.slcan.state == DG_SLCAN_CLOSED,
                                                .company = DG_BUS_SOMEBODY};
        if (dg_bus_frames_set_line(it.bus, &line)) {
            (void)dg_bus_step(it.bus, now);
        }
        if (event.has_frame) {
            const struct dg_tap_event frame = {
                .at = now, .kind = DG_TAP_FRAME, .frame = event.frame};
            (void)dg_bus_rx(it.bus, &frame);
        }
    }
}

/* What the master says to a medium; NULL: by calls. */
static void (*const senders[DG_MEDIUM_COUNT])(dg_ns now, const uint8_t *bytes, size_t n) = {
    [DG_MEDIUM_CHARACTERS] = send_characters,
    [DG_MEDIUM_FRAMES] = send_slcan,
};

/* ------------------------------------------------------------ time */

/* Each moment at which something is due, and what the master does by itself. */
static void pass_to(dg_ns end)
{
    dg_ns next = dg_engine_next(it.engine);

    while (next <= end) {
        const dg_ns at = next > it.now ? next : it.now;
        if (it.chained) {
            chain_catch_up(&it.chain, at);
        }
        const dg_ns later = dg_engine_step(it.engine, at);
        it.now = at;
        next = later > at ? later : at + 1u;
    }
    if (it.chained) {
        chain_catch_up(&it.chain, end);
    }
    (void)dg_engine_step(it.engine, end);
    it.now = end;
}

/* ------------------------------------------------------------ operations */

static void collect(void *ctx, const char *bytes, size_t n)
{
    (void)ctx;
    if (strlen(it.answer) + n < sizeof it.answer) {
        (void)strncat(it.answer, bytes, n);
    }
}

static void ask(const char *line)
{
    it.answer[0] = '\0';
    (void)dg_control_rx(&it.client, it.now, line, strlen(line));
    (void)dg_control_rx(&it.client, it.now, "\n", 1);
    it.answer[strcspn(it.answer, "\n")] = '\0';
}

static void ask_scpi(unsigned number, const char *line)
{
    ask(line);
    told_levels = false;
    if (it.answer[0] == '\0') {
        ask("SYST:ERR?");
    }
    printf("%u %s\n", number, it.answer);
}

static void clock_frame(unsigned number, const char *line)
{
    told_levels = true;
    ask_scpi(number, line);
}

static void send_bytes(unsigned number, const char *digits)
{
    uint8_t bytes[LINE_CHARS_MAX / 2u];

    senders[it.plan.wires[0].stack->medium](it.now, bytes, hf_rig_hex(digits, bytes, sizeof bytes));
    printf("%u\n", number);
}

static const struct dg_ring_state *run_cycle(const uint16_t *out, bool identify)
{
    const struct dg_tap_event event = {
        .at = it.now,
        .kind = DG_TAP_WORDS,
        .words = {.out = out, .count = dg_ring_state(it.bus)->words, .identify = identify},
    };

    (void)dg_bus_rx(it.bus, &event);
    return dg_ring_state(it.bus);
}

/* Four digits a word; those that are not there are 0. */
static void cycle_ring(unsigned number, const char *digits)
{
    const uint16_t *in = dg_engine_wire_of(it.engine, 0)->words.in;
    uint16_t out[WORDS_MAX] = {0};

    for (size_t i = 0; i < WORDS_MAX && strlen(digits) >= 4u; i++, digits += 4) {
        char word[5] = "";
        memcpy(word, digits, 4);
        out[i] = (uint16_t)strtoul(word, NULL, 16);
    }
    const struct dg_ring_state *is = run_cycle(out, false);
    if (is->result == DG_RING_IDENTIFY && !is->dropped) {
        is = run_cycle(out, false);
    }
    if (is->dropped || is->result != DG_RING_OK) {
        printf("%u %d\n", number, DG_HOST_ERR_SILENT);
        return;
    }
    printf("%u 0 ", number);
    for (size_t i = 0; i < is->words; i++) {
        printf("%04x", in[i]);
    }
    printf(";\n");
}

static void identify_ring(unsigned number, const char *nothing)
{
    static const uint16_t out[WORDS_MAX];

    (void)nothing;
    const struct dg_ring_state *is = run_cycle(out, true);
    if (is->dropped) {
        printf("%u %d\n", number, DG_HOST_ERR_SILENT);
        return;
    }
    printf("%u 0 ", number);
    for (size_t i = 0; i < is->reached; i++) {
        printf("%04x", dg_ring_id_word(it.bus, i));
    }
    printf(";\n");
}

static const struct {
    const char *name;
    void (*run)(unsigned number, const char *text);
} operations[] = {
    {"scpi ", ask_scpi},    {"clock ", clock_frame},     {"send ", send_bytes},
    {"cycle ", cycle_ring}, {"identify", identify_ring},
};

static void do_line(unsigned number, char *line)
{
    char *rest = NULL;
    const dg_ns at = strtoull(line, &rest, 10);

    pass_to(at > it.now ? at : it.now);
    for (size_t i = 0; i < DG_COUNT(operations); i++) {
        const size_t n = strlen(operations[i].name);

        if (*rest == ' ' && strncmp(rest + 1, operations[i].name, n) == 0) {
            operations[i].run(number, rest + 1 + n);
            return;
        }
    }
    give_up("no such operation", line);
}

/* ------------------------------------------------------------ from a file to a rig */

static void *allocate(size_t n)
{
    void *memory =
        aligned_alloc(DG_HOST_ALIGN, (n + DG_HOST_ALIGN - 1u) & ~(size_t)(DG_HOST_ALIGN - 1u));

    if (memory == NULL) {
        give_up("no memory", "differential_engine");
    }
    return memory;
}

static void read_plan(const char *file)
{
    static char text[FILE_MAX];
    FILE *stream = fopen(file, "rb");

    if (stream == NULL) {
        give_up("cannot be opened", file);
    }
    const size_t n = fread(text, 1, sizeof text, stream);
    (void)fclose(stream);
    struct dg_plan_error error;
    const struct dg_plan_setup setup = {.size = sizeof setup,
                                        .file = file,
                                        .text = {text, n},
                                        .memory = allocate(FILE_MAX),
                                        .memory_size = FILE_MAX};
    if (dg_plan_read(&it.plan, &setup, &error) != 0 || it.plan.wire_count != 1) {
        give_up(error.what, file);
    }
}

static void make_rig(const char *file)
{
    struct dg_plan_error error;
    const struct dg_engine_setup setup = {.size = sizeof setup,
                                          .plan = &it.plan,
                                          .begin = BEGIN,
                                          .instruments = dg_instruments,
                                          .instrument_count = dg_instrument_count,
                                          .wire = open_door};
    const size_t n = dg_engine_size(&setup);

    it.engine = dg_engine_make(allocate(n), n, &setup, &error);
    if (it.engine == NULL) {
        give_up(error.what[0] != '\0' ? error.what : error.right, file);
    }
    it.bus = dg_engine_bus(it.engine, 0);
    it.chained = it.plan.wires[0].stack->medium == DG_MEDIUM_EDGES;
    if (it.chained) {
        chain_begin(&it.chain, it.engine, BEGIN);
    }
    if (dg_engine_power(it.engine, BEGIN, &error) != 0) {
        give_up(error.what, file);
    }
    it.now = BEGIN;
    dg_control_init(&it.client, dg_engine_control(it.engine), collect, NULL);
}

int main(int argc, char *argv[])
{
    char line[LINE_CHARS_MAX];

    if (argc != 2) {
        fprintf(stderr, "usage: differential_engine RIG.ini < LINES\n");
        return 2;
    }
    read_plan(argv[1]);
    make_rig(argv[1]);
    for (unsigned number = 1; fgets(line, sizeof line, stdin) != NULL; number++) {
        line[strcspn(line, "\n")] = '\0';
        do_line(number, line);
        (void)fflush(stdout);
    }
    return 0;
}
