/* SPDX-License-Identifier: MIT */
/*
 * What goes over a wire in a minute of virtual time, in which everything that can happen to its
 * encoders happens once: a second for each fault, so it is more than a minute where there are many.
 * Compares that with the record, or writes the record anew.
 *
 * NAME.ini is the rig; all that is on its wire is told. NAME.requests has what the master says, a
 * line each, twice for each fault: while it is there, and when it is over. A line "@b wire_" leaves
 * all faults out but those of encoder b whose name begins so, and ends with them: one more encoder
 * needs no minute of its own. The record, NAME.trace, has a line for each frame:
 *
 *   moment, ns | moments in it | direction | bytes | words
 *
 * so that another moment, another byte and another word can be told apart. Brackets say which fault
 * begins; moments count from there. Of levels, "moments in it" has their number, how long they
 * last, and a check sum of all edges; "bytes" has the bits that the master has clocked in, the
 * first one on the left.
 */
#define _GNU_SOURCE
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/fault.h"
#include "give_up.h"
#include "hf_rig.h"
#include "record.h"
#include "timer.h"
#include "trace.h"
#include "virtual_rig.h"

#define MINUTE DG_S(60)
/* A fault, and the time behind it. */
#define FAULT DG_S(1)
#define REQUESTS_MAX 16u
#define REQUEST_MAX 120u
#define FRAME_BYTES_MAX 280u
#define SHOWN_MAX 20u
#define COLUMNS 5u
/* Of levels; more of them are in the check sum only. */
#define BITS_MAX 256u
#define WORDS_MEMORY 4096u
#define BETWEEN " | "
/* Each fault finds the shaft somewhere else. */
#define TURN_MDEG 7310u
/* Steps of a fault beside the requests: it begins, power on, it ends, power on. */
#define OTHER_STEPS 4u

/* What has been told of a frame that is not over. */
struct collected {
    size_t count; /* characters, or levels */
    dg_ns begin;
    dg_ns last;
    dg_ns gap;
    size_t gaps; /* of the same length, the latest */
    bool clock;
    size_t bits; /* clocked in */
    uint32_t sum;
    char bytes[1024];
    char moments[1024];
};

struct recorder {
    const char *name;
    char requests[REQUESTS_MAX][REQUEST_MAX];
    size_t request_count;
    char only[REQUEST_MAX]; /* "ENCODER FAULT", as far as faults have to begin so; empty: all */
    const struct master *master;
    struct virtual_rig rig;
    unsigned turned; /* the shaft, so far, mdeg */
    dg_ns begin;     /* of the section */
    struct lx_tap_listener listener;
    struct dg_words_wire words;
    union {
        max_align_t align;
        unsigned char bytes[WORDS_MEMORY];
    } memory;                        /* theirs */
    const struct dg_tap_event *told; /* while it is */
    struct collected collected;
    FILE *out;
};

/* --- what goes over the wire --- */

static void append_text(char *text, size_t size, const char *more)
{
    const size_t n = strlen(text);
    if (n + strlen(more) >= size) {
        give_up("too long for the recorder", more);
    }
    (void)strcpy(text + n, more);
}

/* "1145833x3": so many characters after each other at this distance. */
static void end_gaps(struct collected *self)
{
    char text[48];
    if (self->gaps > 0) {
        (void)snprintf(text, sizeof text, "%s%" PRIu64 "x%zu", self->moments[0] == '\0' ? "" : " ",
                       self->gap, self->gaps);
        append_text(self->moments, sizeof self->moments, text);
    }
    self->gaps = 0;
}

static void collect_character(struct collected *self, const struct dg_tap_event *event)
{
    char text[8];
    if (self->count == 0) {
        self->begin = event->at;
    } else if (self->gaps > 0 && event->at - self->last == self->gap) {
        self->gaps++;
    } else {
        end_gaps(self);
        self->gap = event->at - self->last;
        self->gaps = 1;
    }
    (void)snprintf(text, sizeof text, "%s%02X%s", self->count == 0 ? "" : " ",
                   event->character.byte, event->character.damaged ? "!" : "");
    append_text(self->bytes, sizeof self->bytes, text);
    self->last = event->at;
    self->count++;
}

/* FNV-1a */
static uint32_t sum_of(uint32_t sum, uint64_t value)
{
    for (; value != 0; value >>= 8) {
        sum = (sum ^ (uint32_t)(value & 0xFFu)) * 16777619u;
    }
    return (sum ^ 0x100u) * 16777619u;
}

static uint8_t value_of(char digit)
{
    return (uint8_t)(digit <= '9' ? digit - '0' : digit - 'A' + 10);
}

static void collect_levels(struct collected *self, const struct dg_tap_event *event)
{
    static const char digits[] = "0123456789ABCDEF";
    if (self->count == 0) {
        self->begin = event->at;
        self->sum = 2166136261u;
        self->clock = true;
    }
    if (!self->clock && event->levels.clock && self->bits < BITS_MAX) {
        char *digit = &self->bytes[self->bits / 4];
        const uint8_t value = self->bits % 4 == 0 ? 0 : value_of(*digit);
        *digit = digits[value | event->levels.data << (3 - self->bits % 4)];
        self->bits++;
    }
    self->clock = event->levels.clock;
    self->sum = sum_of(self->sum, event->at - self->begin);
    self->sum = sum_of(self->sum, 2u * event->levels.clock + event->levels.data);
    self->last = event->at;
    self->count++;
    (void)snprintf(self->moments, sizeof self->moments, "%zu in %" PRIu64 " %08" PRIX32,
                   self->count, self->last - self->begin, self->sum);
}

/* A CAN frame, the words of a ring: what is told at once. */
static void describe_frame(const struct dg_can_frame *frame, char *text, size_t size)
{
    int n = snprintf(text, size, "%03" PRIX32 "#%s", (uint32_t)frame->id, frame->rtr ? "R" : "");
    for (uint8_t i = 0; !frame->rtr && i < frame->dlc; i++) {
        n += snprintf(text + n, size - (size_t)n, "%02X", frame->data[i]);
    }
}

static void describe_words(const struct dg_tap_event *event, char *text, size_t size)
{
    int n = snprintf(text, size, "in");
    for (uint16_t i = 0; i < event->words.count; i++) {
        n += snprintf(text + n, size - (size_t)n, " %04X", event->words.in[i]);
    }
    n += snprintf(text + n, size - (size_t)n, " out");
    for (uint16_t i = 0; i < event->words.count; i++) {
        n += snprintf(text + n, size - (size_t)n, " %04X", event->words.out[i]);
    }
    (void)snprintf(text + n, size - (size_t)n, "%s", event->words.valid ? "" : " invalid");
}

/* A frame, or something in words, is over. */
static void on_line(void *ctx, const struct dg_words_line *line)
{
    struct recorder *self = ctx;
    struct collected *frame = &self->collected;
    end_gaps(frame);
    if (self->told != NULL && self->told->kind == DG_TAP_FRAME) {
        describe_frame(&self->told->frame, frame->bytes, sizeof frame->bytes);
    } else if (self->told != NULL && self->told->kind == DG_TAP_WORDS) {
        describe_words(self->told, frame->bytes, sizeof frame->bytes);
    }
    const dg_ns begin = frame->count > 0 ? frame->begin : line->at;
    (void)fprintf(self->out, "%" PRId64 " | %s | %c | %s | %s\n", (int64_t)(begin - self->begin),
                  frame->moments, line->ours ? '>' : '<', frame->bytes, line->text);
    *frame = (struct collected){.count = 0};
}

/* The words of the wire, which its first event asks for: then the plan is known. */
static void begin_words(struct recorder *self)
{
    const struct dg_words *words = dg_words_of(self->rig.plan.encoders[0].model->stack);
    if (words != NULL && words->size > sizeof self->memory) {
        give_up("the recorder has no memory for these words", self->name);
    }
    self->words = (struct dg_words_wire){words, &self->memory, {on_line, self}};
}

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct recorder *self = ctx;
    if (self->words.to.line == NULL) {
        begin_words(self);
    }
    (void)dg_words_step(&self->words, event->at);
    self->told = event;
    dg_words_event(&self->words, event);
    self->told = NULL;
    if (event->kind == DG_TAP_CHARACTER) {
        collect_character(&self->collected, event);
    } else if (event->kind == DG_TAP_LEVELS) {
        collect_levels(&self->collected, event);
    }
}

static void pass_time(struct recorder *self, dg_ns span)
{
    virtual_rig_pass(&self->rig, span);
    (void)dg_words_step(&self->words, lx_now());
}

/* --- masters --- */

/* The master of a kind of wire. */
struct master {
    const char *wire;
    const char *greeting;                                 /* what it says first, or NULL */
    size_t (*frame)(const char *request, uint8_t *bytes); /* NULL: it is in the rig */
};

static size_t frame_rs485(const char *request, uint8_t *bytes)
{
    const size_t n = hf_rig_hex(request, bytes, DG_HF_FRAME_MAX);
    bytes[n] = hf_rig_xor(bytes, n);
    return n + 1;
}

static size_t frame_slcan(const char *request, uint8_t *bytes)
{
    const size_t n = strlen(request);
    memcpy(bytes, request, n);
    bytes[n] = '\r';
    return n + 1;
}

/* Transaction 1, protocol 0, length, unit 1. */
static size_t frame_modbus(const char *request, uint8_t *bytes)
{
    static const uint8_t header[] = {0, 1, 0, 0, 0, 0, 1};
    memcpy(bytes, header, sizeof header);
    const size_t n = hf_rig_hex(request, bytes + sizeof header, FRAME_BYTES_MAX - sizeof header);
    bytes[5] = (uint8_t)(n + 1);
    return n + sizeof header;
}

static const struct master masters[] = {
    {"rs485", NULL, frame_rs485},
    {"slcan", "S5\rO", frame_slcan},
    {"modbus", NULL, frame_modbus},
    {"sim", NULL, NULL},
};

static void say_request(struct recorder *self, const char *text)
{
    uint8_t bytes[FRAME_BYTES_MAX];
    if (self->master->frame == NULL) {
        const dg_ns at = lx_now() - self->begin;
        virtual_rig_ask(&self->rig, text);
        if (self->rig.answer[0] == '\0') {
            virtual_rig_ask(&self->rig, "SYST:ERR?");
        }
        (void)fprintf(self->out, "%" PRIu64 " |  | = |  | %s: %s\n", at, text, self->rig.answer);
        virtual_rig_order(&self->rig, "*CLS");
        return;
    }
    const size_t n = self->master->frame(text, bytes);
    virtual_rig_say(&self->rig, bytes, n);
}

static void connect_master(struct recorder *self)
{
    const char *kind = virtual_rig_wire(&self->rig);
    for (size_t i = 0; i < DG_COUNT(masters); i++) {
        self->master = strcmp(masters[i].wire, kind) == 0 ? &masters[i] : self->master;
    }
    if (self->master == NULL) {
        give_up("no master for this kind of wire", kind);
    }
    if (self->master->frame == NULL) {
        return;
    }
    virtual_rig_connect(&self->rig);
    if (self->master->greeting != NULL) {
        say_request(self, self->master->greeting);
    }
}

/* --- a minute --- */

static void request_all(struct recorder *self, dg_ns step)
{
    for (size_t i = 0; i < self->request_count; i++) {
        say_request(self, self->requests[i]);
        pass_time(self, step);
    }
}

/* Damage of an EEPROM is seen from the next start on. */
static void restart_encoder(struct recorder *self, bool it, dg_ns step)
{
    if (it) {
        virtual_rig_order(&self->rig, "POW OFF");
    }
    pass_time(self, step);
    if (it) {
        virtual_rig_order(&self->rig, "POW ON");
    }
    pass_time(self, step);
}

/* Its moments count from here, so that one more fault moves no other one's. */
static void begin_section(struct recorder *self, const char *who, const char *what)
{
    (void)fprintf(self->out, "[%s %s]\n", who, what);
    self->begin = lx_now();
}

static bool is_wanted(const struct recorder *self, const char *encoder, const char *fault)
{
    char name[2 * REQUEST_MAX];
    (void)snprintf(name, sizeof name, "%s %s", encoder, fault);
    return strncmp(name, self->only, strlen(self->only)) == 0;
}

static void live_with_fault(struct recorder *self, const char *encoder,
                            const struct dg_fault_entry *entry, dg_ns step)
{
    const bool stored = entry->row == NULL;
    begin_section(self, encoder, entry->name);
    virtual_rig_order(&self->rig, "SHAF:POS %u.%03uDEG", self->turned / 1000u,
                      self->turned % 1000u);
    virtual_rig_order(&self->rig, "FAUL:SET %s", entry->name);
    restart_encoder(self, stored, step);
    request_all(self, step);
    virtual_rig_order(&self->rig, "FAUL:CLE");
    restart_encoder(self, stored, step);
    request_all(self, step);
}

static void live_with_faults(struct recorder *self)
{
    const dg_ns step = FAULT / (2 * self->request_count + OTHER_STEPS) / 1000 * 1000;
    const dg_ns end = lx_now() + MINUTE;
    struct dg_fault_entry entry;
    const struct dg_encoder *encoder = NULL;
    for (size_t i = 0; (encoder = virtual_rig_encoder(&self->rig, i)) != NULL; i++) {
        const struct dg_fault_target target = dg_encoder_target(encoder);
        virtual_rig_order(&self->rig, "INST:SEL %s", encoder->name);
        for (size_t index = 0; dg_fault_entry(&target, index, &entry); index++) {
            self->turned += TURN_MDEG;
            if (is_wanted(self, encoder->name, entry.name)) {
                live_with_fault(self, encoder->name, &entry, step);
            }
        }
    }
    begin_section(self, "all", "healthy");
    while (self->only[0] == '\0' && lx_now() < end) {
        request_all(self, step);
    }
}

static void read_requests(struct recorder *self, const char *path)
{
    char line[REQUEST_MAX];
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        give_up("cannot open", path);
    }
    while (fgets(line, sizeof line, file) != NULL) {
        const size_t n = strcspn(line, "\n");
        if (line[n] == '\0' || self->request_count == REQUESTS_MAX) {
            give_up("a shorter line, or fewer of them, are right", path);
        }
        line[n] = '\0';
        if (line[0] == '@') {
            (void)strcpy(self->only, line + 1);
        } else if (line[0] != '#') {
            (void)strcpy(self->requests[self->request_count++], line);
        }
    }
    (void)fclose(file);
}

static void record_minute(struct recorder *self, const char *rig)
{
    self->listener = (struct lx_tap_listener){.event = on_event, .ctx = self};
    virtual_rig_open(&self->rig, rig, &self->listener);
    self->begin = lx_now();
    connect_master(self);
    live_with_faults(self);
    (void)dg_words_step(&self->words, DG_NEVER);
    virtual_rig_close(&self->rig);
}

/* --- the record --- */

/* Which columns differ, and the first few lines. */
struct differences {
    unsigned shown;
    unsigned columns[COLUMNS];
};

/* @return the next column of `*line`, with its length; NULL behind the last */
static const char *next_column(const char **line, size_t *length)
{
    const char *column = *line;
    const char *end = column == NULL ? NULL : strstr(column, BETWEEN);
    *length = column == NULL ? 0 : end == NULL ? strlen(column) : (size_t)(end - column);
    *line = end == NULL ? NULL : end + strlen(BETWEEN);
    return column;
}

static void show_line(void *ctx, const char *section, const char *was, const char *is)
{
    struct differences *self = ctx;
    const char *before = was;
    const char *now = is;
    for (size_t i = 0; i < COLUMNS; i++) {
        size_t length[2];
        const char *const columns[2] = {next_column(&before, &length[0]),
                                        next_column(&now, &length[1])};
        self->columns[i] += columns[0] == NULL || columns[1] == NULL || length[0] != length[1] ||
                            memcmp(columns[0], columns[1], length[0]) != 0;
    }
    if (self->shown++ < SHOWN_MAX) {
        (void)printf("%s\n  before: %s\n  now:    %s\n", section, was == NULL ? "-" : was,
                     is == NULL ? "-" : is);
    }
}

int main(int argc, char **argv)
{
    struct recorder recorder = {.name = NULL};
    struct differences differences = {.shown = 0};
    char path[4096];
    char *now = NULL;
    size_t size = 0;
    const bool update = argc == 3 && strcmp(argv[1], "--update") == 0;
    if (argc != 2 && !update) {
        (void)fprintf(stderr, "usage: %s [--update] FOLDER/NAME\n", argv[0]);
        return 2;
    }
    recorder.name = argv[argc - 1];
    (void)snprintf(path, sizeof path, "%s.requests", recorder.name);
    read_requests(&recorder, path);
    recorder.out = open_memstream(&now, &size);
    (void)snprintf(path, sizeof path, "%s.ini", recorder.name);
    record_minute(&recorder, path);
    (void)fclose(recorder.out);
    (void)snprintf(path, sizeof path, "%s.trace", recorder.name);
    const unsigned lines = record_settle(path, now, update, show_line, &differences);
    (void)printf(
        "%u lines differ: %u moments, %u moments inside, %u directions, %u bytes, %u words\n",
        lines, differences.columns[0], differences.columns[1], differences.columns[2],
        differences.columns[3], differences.columns[4]);
    free(now);
    return lines == 0 ? 0 : 1;
}
