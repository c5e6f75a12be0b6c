/* SPDX-License-Identifier: MIT */
/*
 * What a script can do to an encoder: a row for each word.
 */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "play.h"

/* 2^-32 turns per second are a whole number for each 1.875 rpm. */
#define MRPM_STEP 1875
#define RATE_OF_STEP ((int64_t)1 << 27)
#define CHARACTERS_MAX 16u
/* Longest step. */
#define SLICE (5 * MS)

static uint8_t image[HOST_RIG_MEMORY_MAX];

/* Add to the answer, which stands behind the operation's name. */
__attribute__((format(printf, 2, 3))) static void say(struct player *self, const char *format, ...)
{
    va_list arguments;

    if (self->said_n >= sizeof self->said) {
        return; /* player_perform() refuses it */
    }
    va_start(arguments, format);
    const int n =
        vsnprintf(self->said + self->said_n, sizeof self->said - self->said_n, format, arguments);
    va_end(arguments);
    self->said_n += n > 0 ? (size_t)n : 0;
}

static uint64_t read_number(const char *word)
{
    return strtoull(word, NULL, 0);
}

/* Two digits a byte; "-": none. @return bytes */
static size_t read_bytes(const char *word, uint8_t *to, size_t most)
{
    size_t n = 0;

    while (n < most && word[2 * n] != '\0' && word[2 * n + 1] != '\0') {
        const char digits[] = {word[2 * n], word[2 * n + 1], '\0'};

        to[n++] = (uint8_t)strtoul(digits, NULL, 16);
    }
    return n;
}

static void say_bytes(struct player *self, const uint8_t *bytes, size_t n)
{
    say(self, " ");
    for (size_t i = 0; i < n; i++) {
        say(self, "%02x", bytes[i]);
    }
    say(self, ";");
}

/* FNV-1a over the EEPROM. */
static uint32_t sum_memory(const struct dg_host *host)
{
    const size_t n = dg_host_memory_size(host);
    uint32_t sum = UINT32_C(2166136261);

    if (dg_host_memory_copy(host, image, sizeof image) == DG_HOST_OK) {
        for (size_t i = 0; i < n; i++) {
            sum = (sum ^ image[i]) * UINT32_C(16777619);
        }
    }
    return sum;
}

/* ------------------------------------------------------------ settings, power, physics */

static void set_setting(struct player *self, char *words[])
{
    say(self, " %d", dg_host_set(self->host, words[0], words[1]));
}

/* In a new handle with the EEPROM of this one. */
static void renew_handle(struct player *self)
{
    struct dg_host *other = player_make_alike(self, true);
    const size_t n = dg_host_memory_size(self->host);

    if (dg_host_memory_copy(self->host, image, n) != DG_HOST_OK ||
        dg_host_memory_load(other, image, n) != DG_HOST_OK) {
        say(self, " the EEPROM is not taken over");
    }
    for (int i = 1; i >= 0; i--) { /* encoders look back when they measure speed */
        dg_host_shaft(other, self->turns[i].at, self->turns[i].angle, self->turns[i].rate);
    }
    player_exchange(self, other);
}

static void switch_power(struct player *self, char *words[])
{
    const bool on = read_number(words[0]) != 0;

    if (on && self->was_on && (self->disturbance & DISTURB_FRESH) != 0 &&
        !dg_host_powered(self->host)) {
        renew_handle(self);
    }
    const int result = dg_host_power(self->host, self->now, on);
    self->was_on = self->was_on || (on && result == DG_HOST_OK);
    say(self, " %d", result);
}

static void turn_driver(struct player *self, const struct turn *turn)
{
    (void)dg_shaft_set_position(&self->driver, turn->at, turn->angle);
    (void)dg_shaft_set_velocity(&self->driver, turn->at,
                                (int32_t)(turn->rate / RATE_OF_STEP * MRPM_STEP));
}

static void turn_shaft(struct player *self, char *words[])
{
    const int64_t steps = strtoll(words[1], NULL, 0) / MRPM_STEP;
    const struct turn turn = {self->now, strtoll(words[0], NULL, 0), steps * RATE_OF_STEP};

    if (self->turns[0].at != turn.at) {
        self->turns[1] = self->turns[0];
    }
    self->turns[0] = turn;
    if (self->panel != NULL) {
        turn_driver(self, &turn);
    } else {
        dg_host_shaft(self->host, turn.at, turn.angle, turn.rate);
    }
}

static void set_world(struct player *self, char *words[])
{
    say(self, " %d",
        dg_host_world_set(self->host, self->now, words[0], strtoll(words[1], NULL, 0)));
}

/* The encoder sits on the panel's shaft then, which another one drives: it goes on as it did. */
static void make_panel(struct player *self)
{
    self->panel = dg_host_panel_make(&self->panel_place, sizeof self->panel_place, self->host);
    if (self->panel == NULL) {
        return; /* it was never on */
    }
    dg_shaft_init(&self->driver);
    for (int i = 1; i >= 0; i--) {
        turn_driver(self, &self->turns[i]);
    }
    (void)dg_shaft_couple(dg_host_panel_shaft(self->panel), &self->driver, 1, 1);
}

static void set_fault(struct player *self, char *words[])
{
    const bool on = read_number(words[1]) != 0;

    if (self->panel == NULL) {
        make_panel(self);
    }
    say(self, " %d",
        self->panel == NULL ? DG_HOST_ERR_STATE
                            : dg_host_fault_set(self->panel, self->now, words[0], on));
}

/* ------------------------------------------------------------ wires */

/* As a master does that knows what the encoder is set to. */
static void send_characters(struct player *self, char *words[])
{
    struct dg_host_event event = {.at = self->now, .kind = DG_HOST_BYTES};
    struct dg_host_uart uart = {.baud = 1};
    uint8_t bytes[LINE_MAX_CHARS / 2u];
    const size_t n = read_bytes(words[0], bytes, sizeof bytes);
    int result = dg_host_uart(self->host, &uart);
    const uint64_t bits = uart.parity == 'N' ? 10 : 11;

    event.id = (uint32_t)((bits * SECOND + uart.baud - 1u) / uart.baud);
    for (size_t done = 0; done < n && result == DG_HOST_OK; done += event.length) {
        event.at = self->now + done * event.id;
        event.length = (uint8_t)(n - done < CHARACTERS_MAX ? n - done : CHARACTERS_MAX);
        memset(event.data, 0, sizeof event.data);
        memcpy(event.data, bytes + done, event.length);
        result = dg_host_send(self->host, &event);
    }
    say(self, " %d", result);
}

static void send_event(struct player *self, struct dg_host_event event, const char *data)
{
    event.at += self->now;
    if (data != NULL) {
        event.length = (uint8_t)read_bytes(data, event.data, sizeof event.data);
    }
    say(self, " %d", dg_host_send(self->host, &event));
}

/* DELAY CHARACTER-NS FLAGS BYTES */
static void send_raw_characters(struct player *self, char *words[])
{
    send_event(self,
               (struct dg_host_event){.at = read_number(words[0]),
                                      .id = (uint32_t)read_number(words[1]),
                                      .flags = (uint16_t)read_number(words[2]),
                                      .kind = DG_HOST_BYTES},
               words[3]);
}

static void send_frame(struct player *self, char *words[])
{
    send_event(self,
               (struct dg_host_event){.id = (uint32_t)read_number(words[0]), .kind = DG_HOST_CAN},
               words[1]);
}

static void send_remote_frame(struct player *self, char *words[])
{
    send_event(self,
               (struct dg_host_event){.id = (uint32_t)read_number(words[0]),
                                      .flags = DG_HOST_REMOTE,
                                      .kind = DG_HOST_CAN,
                                      .length = (uint8_t)read_number(words[1])},
               NULL);
}

static void change_bus(struct player *self, char *words[])
{
    send_event(self,
               (struct dg_host_event){.id = (uint32_t)read_number(words[0]), .kind = DG_HOST_BUS},
               NULL);
}

/* A cycle happens at once: what comes back is of this moment. */
static void exchange_words(struct player *self, uint32_t out, uint16_t flags)
{
    const struct dg_host_event event = {
        .at = self->now, .id = out, .flags = flags, .kind = DG_HOST_WORDS};
    struct dg_host_event back = {0};
    int result = dg_host_send(self->host, &event);

    if (result == DG_HOST_OK) {
        player_step(self, self->now);
        result = dg_host_receive(self->host, &back) == 1 ? DG_HOST_OK : DG_HOST_ERR_SILENT;
    }
    say(self, " %d", result);
    if (result == DG_HOST_OK) {
        say(self, "%s", back.at == self->now ? "" : " late");
        say_bytes(self, back.data, back.length);
    }
}

static void cycle_words(struct player *self, char *words[])
{
    exchange_words(self, (uint32_t)read_number(words[0]), 0);
}

static void identify_words(struct player *self, char *words[])
{
    (void)words;
    exchange_words(self, 0, DG_HOST_IDENTIFY);
}

/* HALF-PERIOD COUNT: falling and rising edges by turns */
static void clock_edges(struct player *self, char *words[])
{
    const uint64_t half = read_number(words[0]);
    const uint64_t count = read_number(words[1]);

    say(self, " ");
    for (uint64_t i = 0; i < count; i++) {
        const uint64_t at = self->now + half;

        player_disturb(self, at);
        const int level = dg_host_clock(self->host, at, (i & 1u) != 0);
        self->now = at;
        player_drain(self);
        say(self, "%d", level);
    }
}

static void set_chain(struct player *self, char *words[])
{
    say(self, " %d", dg_host_behind(self->host, self->now, read_number(words[0]) != 0));
}

static void read_frame(struct player *self, char *words[])
{
    struct dg_host_frame frame = {0};
    const int result = dg_host_frame(self->host, self->now, &frame);

    (void)words;
    say(self, " %d", result);
    if (result == DG_HOST_OK) {
        say(self,
            " %" PRIu64 " %" PRIu64 " %" PRIx64 "/%u %" PRIx64 " %" PRIx32 " %" PRIx32 " %u%u%u %u",
            frame.at, frame.end, frame.bits, frame.count, frame.position, frame.multiturn,
            frame.singleturn, frame.error, frame.warning, frame.good, frame.life);
        player_step(self, frame.end);
    }
}

/* What is in the frame, and no moment. */
static void latch_frame(struct player *self, char *words[])
{
    struct dg_host_frame frame = {0};
    const int result = dg_host_frame(self->host, self->now, &frame);

    (void)words;
    say(self, " %d %" PRIx64 "/%u %" PRIx64 " %u%u%u", result, frame.bits, frame.count,
        frame.position, frame.error, frame.warning, frame.good);
    if (result == DG_HOST_OK) {
        player_step(self, frame.end);
    }
}

static void end_registers(struct player *self, int result, uint64_t now)
{
    say(self, " %d", result);
    if (result >= 0) {
        say(self, " %" PRIu64, now);
        player_step(self, now);
    }
}

static void read_registers(struct player *self, char *words[])
{
    uint8_t bytes[64];
    uint64_t now = self->now;
    const int result = dg_host_registers_read(self->host, &now, (uint8_t)read_number(words[0]),
                                              bytes, (size_t)read_number(words[1]));

    end_registers(self, result, now);
    say_bytes(self, bytes, result > 0 ? (size_t)result : 0);
}

static void write_registers(struct player *self, char *words[])
{
    uint8_t bytes[64];
    uint64_t now = self->now;
    const size_t n = read_bytes(words[1], bytes, sizeof bytes);
    const int result =
        dg_host_registers_write(self->host, &now, (uint8_t)read_number(words[0]), bytes, n);

    end_registers(self, result, now);
}

/* ------------------------------------------------------------ looks */

static void print_position(struct player *self, char *words[])
{
    uint64_t counts = 0;
    const int result = dg_host_position(self->host, self->now, &counts);

    (void)words;
    say(self, " %d %" PRIx64, result, counts);
}

static void print_sincos(struct player *self, char *words[])
{
    int32_t uv[4] = {0};
    const int result = dg_host_sincos(self->host, self->now, uv);

    (void)words;
    say(self, " %d %" PRId32 " %" PRId32 " %" PRId32 " %" PRId32, result, uv[0], uv[1], uv[2],
        uv[3]);
}

static void print_next(struct player *self, char *words[])
{
    (void)words;
    say(self, " %" PRIu64, dg_host_next(self->host));
}

static void print_memory(struct player *self, char *words[])
{
    (void)words;
    say(self, " %08" PRIx32, sum_memory(self->host));
}

/* Another encoder of the same settings starts with this one's EEPROM, a second after the latest
 * moment, and keeps it. */
static void mount_memory(struct player *self, char *words[])
{
    struct dg_host *other = player_make_alike(self, false);
    const size_t n = dg_host_memory_size(self->host);
    int result = dg_host_memory_copy(self->host, image, n);

    (void)words;
    result = result != DG_HOST_OK ? result : dg_host_memory_load(other, image, n);
    result = result != DG_HOST_OK ? result : dg_host_power(other, self->now, true);
    (void)dg_host_step(other, self->now + SECOND);
    say(self, " %d %08" PRIx32, result, sum_memory(other));
}

/* clang-format off */
static const struct {
    const char *name;
    int words;
    void (*run)(struct player *self, char *words[]);
} operations[] = {
    {"bus",      1, change_bus},
    {"bytes",    1, send_characters},
    {"can",      2, send_frame},
    {"chain",    1, set_chain},
    {"cycle",    1, cycle_words},
    {"edges",    2, clock_edges},
    {"eeprom",   0, print_memory},
    {"fault",    2, set_fault},
    {"frame",    0, read_frame},
    {"identify", 0, identify_words},
    {"latch",    0, latch_frame},
    {"mount",    0, mount_memory},
    {"next",     0, print_next},
    {"position", 0, print_position},
    {"power",    1, switch_power},
    {"raw",      4, send_raw_characters},
    {"read",     2, read_registers},
    {"remote",   2, send_remote_frame},
    {"set",      2, set_setting},
    {"shaft",    2, turn_shaft},
    {"sincos",   0, print_sincos},
    {"world",    2, set_world},
    {"write",    2, write_registers},
};
/* clang-format on */

/* Often enough that nothing is lost: a SYNC producer and its PDOs come each millisecond. */
static void pass_time(struct player *self, uint64_t at)
{
    while (self->now + SLICE < at) {
        player_step(self, self->now + SLICE);
        player_drain(self);
    }
    player_step(self, at);
    player_drain(self);
}

bool player_perform(struct player *self, unsigned number, char *words[], int count)
{
    const uint64_t at = read_number(words[0]);

    for (size_t i = 0; i < DG_COUNT(operations); i++) {
        if (strcmp(words[1], operations[i].name) == 0 && count == operations[i].words + 2) {
            player_disturb(self, at);
            pass_time(self, at);
            self->said_n = 0;
            self->said[0] = '\0';
            operations[i].run(self, words + 2);
            player_step(self, self->now);
            player_step(self, self->now); /* lets go what wire_delay has taken in the one before */
            player_drain(self);
            printf("%u %s%s%s\n", number, self->label, words[1], self->said);
            return self->said_n < sizeof self->said;
        }
    }
    return false;
}
