/* SPDX-License-Identifier: MIT */
/*
 * What goes over a wire in a minute of virtual time, in which everything that can happen to its
 * encoders happens once: a second for each fault, so it is more than a minute where there are many.
 * Compares that with the record, or writes the record anew.
 *
 * NAME.ini is the rig; all that is on its wire is told. NAME.requests has what the master says, a
 * line each, twice for each fault: while it is there, and when it is over. The record, NAME.trace,
 * has a line for each frame:
 *
 *   moment, ns | moments in it | direction | bytes | words
 *
 * so that another moment, another byte and another word can be told apart. Brackets say which fault
 * begins; moments count from there. Of levels, "moments in it" has their number, how long they
 * last, and a check sum of all edges; "bytes" has the bits that the master has clocked in, the
 * first one on the left.
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <inttypes.h>
#include <linux/sockios.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "drehgeber/fault.h"
#include "hf_rig.h"
#include "record.h"
#include "rig_parts.h"
#include "timer.h"

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
#define BETWEEN " | "
/* Each fault finds the shaft somewhere else. */
#define TURN_MDEG 7310u
/* Steps of a fault beside the requests: it begins, power on, it ends, power on. */
#define OTHER_STEPS 4u
#define PATIENCE DG_S(10)
/* More than such a rig has. */
#define DESCRIPTORS 256

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
    const struct master *master;
    int line; /* the master's connection; -1: it has none */
    struct lx_plan plan;
    sd_event *event;
    struct lx_rig *rig;
    dg_ns begin; /* of the section */
    struct lx_tap_listener listener;
    struct lx_decoder decoder;
    const struct lx_tap_event *told; /* while it is */
    struct collected collected;
    struct dg_control control;
    char answer[512];
    FILE *out;
};

/* --- what goes over the wire --- */

static void append_text(char *text, size_t size, const char *more)
{
    const size_t n = strlen(text);
    if (n + strlen(more) >= size) {
        record_fail("too long for the recorder", more);
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

static void collect_character(struct collected *self, const struct lx_tap_event *event)
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

static void collect_levels(struct collected *self, const struct lx_tap_event *event)
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

static void describe_words(const struct lx_tap_event *event, char *text, size_t size)
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
static void on_line(void *ctx, dg_ns at, bool ours, const char *words)
{
    struct recorder *self = ctx;
    struct collected *frame = &self->collected;
    end_gaps(frame);
    if (self->told != NULL && self->told->kind == LX_TAP_FRAME) {
        describe_frame(&self->told->frame, frame->bytes, sizeof frame->bytes);
    } else if (self->told != NULL && self->told->kind == LX_TAP_WORDS) {
        describe_words(self->told, frame->bytes, sizeof frame->bytes);
    }
    const dg_ns begin = frame->count > 0 ? frame->begin : at;
    (void)fprintf(self->out, "%" PRId64 " | %s | %c | %s | %s\n", (int64_t)(begin - self->begin),
                  frame->moments, ours ? '>' : '<', frame->bytes, words);
    *frame = (struct collected){.count = 0};
}

static void on_event(void *ctx, const struct lx_tap_event *event)
{
    struct recorder *self = ctx;
    (void)lx_decoder_step(&self->decoder, event->at);
    self->told = event;
    lx_decoder_event(&self->decoder, event);
    self->told = NULL;
    if (event->kind == LX_TAP_CHARACTER) {
        collect_character(&self->collected, event);
    } else if (event->kind == LX_TAP_LEVELS) {
        collect_levels(&self->collected, event);
    }
}

/* --- time --- */

/* Everybody who has been told something does what there is to do. */
static void serve_rig(struct recorder *self)
{
    char heard[512];
    while (sd_event_run(self->event, 0) > 0) {
    }
    while (self->line >= 0 && recv(self->line, heard, sizeof heard, MSG_DONTWAIT) > 0) {
    }
}

static void pass_time(struct recorder *self, dg_ns span)
{
    const dg_ns end = lx_now() + span;
    serve_rig(self);
    while (lx_time_pass(end)) {
        serve_rig(self);
    }
    (void)lx_decoder_step(&self->decoder, lx_now());
}

/* --- the control plane --- */

static void on_answer(void *ctx, const char *bytes, size_t n)
{
    struct recorder *self = ctx;
    const size_t length = strlen(self->answer);
    if (length + n < sizeof self->answer) {
        memcpy(self->answer + length, bytes, n);
        self->answer[length + n] = '\0';
    }
}

static void ask_rig(struct recorder *self, const char *command)
{
    self->answer[0] = '\0';
    (void)dg_control_rx(&self->control, lx_now(), command, strlen(command));
    (void)dg_control_rx(&self->control, lx_now(), "\n", 1);
    lx_rig_settle(self->rig, lx_now());
    self->answer[strcspn(self->answer, "\n")] = '\0';
}

/* What must not be refused. */
static void order_rig(struct recorder *self, const char *format, ...)
{
    char command[256];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(command, sizeof command, format, arguments);
    va_end(arguments);
    ask_rig(self, command);
    ask_rig(self, "SYST:ERR?");
    if (self->answer[0] != '0') {
        record_fail(self->answer, command);
    }
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

/* The rig's end of the master's connection: it is in this process, too. */
static int find_other_end(const struct recorder *self)
{
    struct sockaddr_in master;
    struct sockaddr_in peer;
    socklen_t size = sizeof master;
    (void)getsockname(self->line, (struct sockaddr *)&master, &size);
    for (int fd = 0; fd < DESCRIPTORS; fd++) {
        size = sizeof peer;
        if (getpeername(fd, (struct sockaddr *)&peer, &size) == 0 && size == sizeof peer &&
            memcmp(&peer, &master, sizeof peer) == 0) {
            return fd;
        }
    }
    record_fail("the rig has closed the master's connection", self->name);
}

/* All of it is there before time goes on. */
static void await_arrival(const struct recorder *self, size_t n)
{
    const dg_ns end = lx_real_now() + PATIENCE;
    const int other = find_other_end(self);
    int come = 0;
    while (ioctl(other, SIOCINQ, &come) == 0 && (size_t)come < n) {
        if (lx_real_now() > end) {
            record_fail("what the master says does not arrive", self->name);
        }
    }
}

static void say_request(struct recorder *self, const char *text)
{
    uint8_t bytes[FRAME_BYTES_MAX];
    if (self->master->frame == NULL) {
        const dg_ns at = lx_now() - self->begin;
        ask_rig(self, text);
        if (self->answer[0] == '\0') {
            ask_rig(self, "SYST:ERR?");
        }
        (void)fprintf(self->out, "%" PRIu64 " |  | = |  | %s: %s\n", at, text, self->answer);
        order_rig(self, "*CLS");
        return;
    }
    const size_t n = self->master->frame(text, bytes);
    if (send(self->line, bytes, n, MSG_NOSIGNAL) != (ssize_t)n) {
        record_fail("the master's connection is closed", self->name);
    }
    await_arrival(self, n);
    serve_rig(self);
}

static void connect_master(struct recorder *self)
{
    const char *kind = self->plan.wires[0].kind->name;
    for (size_t i = 0; i < DG_COUNT(masters); i++) {
        self->master = strcmp(masters[i].wire, kind) == 0 ? &masters[i] : self->master;
    }
    if (self->master == NULL) {
        record_fail("no master for this kind of wire", kind);
    }
    if (self->master->frame == NULL) {
        return;
    }
    static const char host[] = "127.0.0.1:";
    const char *address = strstr(lx_rig_address(self->rig, &self->rig->stations[0]), host);
    if (address == NULL) {
        record_fail("a wire on a TCP port of 127.0.0.1 is right", self->name);
    }
    const struct sockaddr_in to = {
        .sin_family = AF_INET,
        .sin_port = htons((uint16_t)strtoul(address + strlen(host), NULL, 10)),
        .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
    };
    self->line = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(self->line, (const struct sockaddr *)&to, sizeof to) != 0) {
        record_fail("cannot connect", address);
    }
    serve_rig(self);
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
        order_rig(self, "POW OFF");
    }
    pass_time(self, step);
    if (it) {
        order_rig(self, "POW ON");
    }
    pass_time(self, step);
}

/* Its moments count from here, so that one more fault moves no other one's. */
static void begin_section(struct recorder *self, const char *who, const char *what)
{
    (void)fprintf(self->out, "[%s %s]\n", who, what);
    self->begin = lx_now();
}

static void live_with_faults(struct recorder *self)
{
    const dg_ns step = FAULT / (2 * self->request_count + OTHER_STEPS) / 1000 * 1000;
    const dg_ns end = lx_now() + MINUTE;
    struct dg_fault_entry entry;
    unsigned turned = 0;
    for (size_t i = 0; i < self->plan.encoder_count; i++) {
        const struct dg_encoder *encoder = self->rig->control.encoders[i];
        const struct dg_fault_target target = dg_encoder_target(encoder);
        order_rig(self, "INST:SEL %s", encoder->name);
        for (size_t index = 0; dg_fault_entry(&target, index, &entry); index++) {
            const bool stored = entry.row == NULL;
            turned += TURN_MDEG;
            begin_section(self, encoder->name, entry.name);
            order_rig(self, "SHAF:POS %u.%03uDEG", turned / 1000u, turned % 1000u);
            order_rig(self, "FAUL:SET %s", entry.name);
            restart_encoder(self, stored, step);
            request_all(self, step);
            order_rig(self, "FAUL:CLE");
            restart_encoder(self, stored, step);
            request_all(self, step);
        }
    }
    begin_section(self, "all", "healthy");
    while (lx_now() < end) {
        request_all(self, step);
    }
}

static void read_requests(struct recorder *self, const char *path)
{
    char line[REQUEST_MAX];
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        record_fail("cannot open", path);
    }
    while (fgets(line, sizeof line, file) != NULL) {
        const size_t n = strcspn(line, "\n");
        if (line[n] == '\0' || self->request_count == REQUESTS_MAX) {
            record_fail("a shorter line, or fewer of them, are right", path);
        }
        line[n] = '\0';
        if (line[0] != '#') {
            (void)strcpy(self->requests[self->request_count++], line);
        }
    }
    (void)fclose(file);
}

static void record_minute(struct recorder *self, const char *rig)
{
    static const struct lx_say quiet = {.quiet = true};
    struct lx_error error = {.right = ""};
    if (lx_plan_read(&self->plan, rig, &error) != 0) {
        record_fail(lx_error_line(&error).text, rig);
    }
    if (self->plan.wire_count != 1 || sd_event_new(&self->event) < 0) {
        record_fail("a rig with one wire is right", rig);
    }
    lx_time_own();
    const struct lx_rig_setup setup = {.event = self->event, .say = &quiet, .plan = &self->plan};
    if (lx_rig_open(&self->rig, &setup, lx_now(), &error) != LX_RIG_OK) {
        record_fail(lx_error_line(&error).text, rig);
    }
    self->begin = lx_now();
    lx_decoder_init(&self->decoder, on_line, self);
    self->listener = (struct lx_tap_listener){.event = on_event, .ctx = self};
    lx_tap_add(&self->rig->wires[0].bus->tap, &self->listener);
    dg_control_init(&self->control, lx_rig_control(self->rig), on_answer, self);
    connect_master(self);
    live_with_faults(self);
    (void)lx_decoder_step(&self->decoder, DG_NEVER);
    lx_tap_remove(&self->rig->wires[0].bus->tap, &self->listener);
    if (self->line >= 0) {
        (void)close(self->line);
    }
    (void)lx_rig_close(self->rig, &error);
    (void)sd_event_unref(self->event);
    lx_plan_free(&self->plan);
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
    struct recorder recorder = {.line = -1};
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
    /* No control plane: its socket would be somebody else's business. */
    (void)setenv("XDG_RUNTIME_DIR", "/dev/null", 1);
    (void)unsetenv("RUNTIME_DIRECTORY");
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
