/* SPDX-License-Identifier: MIT */
/* One row for each command: in which modes it is allowed, how many words it has, what it does. */
#define _GNU_SOURCE
#include "socketcand.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OK "< ok >"
/* "send", identifier, length, data. */
#define WORDS_MAX 11u
#define BLANKS " \t\r\n"

#define ID_MAX 0x7FFu
#define EXTENDED_ID_MAX 0x1FFFFFFFu
#define EXTENDED_DIGITS 8u

/* Modes a command is allowed in. */
enum {
    NO_BUS = 1 << LX_SOCKETCAND_NO_BUS,
    BCM = 1 << LX_SOCKETCAND_BCM,
    RAW = 1 << LX_SOCKETCAND_RAW,
    ANY = NO_BUS | BCM | RAW,
};

struct words {
    const char *bus;
    size_t count;
    const char *word[WORDS_MAX];
};

const char lx_socketcand_hello[] = "< hi >";

/* Up to `digits` hexadecimal digits and nothing else; false when they are not, or beyond `most`. */
static bool take_hex_word(const char *word, size_t digits, uint32_t most, uint32_t *value)
{
    const size_t n = strlen(word);
    if (n == 0 || n > digits || strspn(word, "0123456789ABCDEFabcdef") != n) {
        return false;
    }
    *value = (uint32_t)strtoul(word, NULL, 16);
    return *value <= most;
}

/* 8 digits are an identifier of 29 bits. */
static bool take_id(const char *word, struct lx_can_wide *frame)
{
    frame->extended = strlen(word) == EXTENDED_DIGITS;
    return take_hex_word(word, EXTENDED_DIGITS, frame->extended ? EXTENDED_ID_MAX : ID_MAX,
                         &frame->id);
}

static void open_bus(struct lx_socketcand *self, const struct words *words,
                     struct lx_socketcand_event *event)
{
    if (words->bus[0] != '\0' && strcmp(words->bus, words->word[1]) != 0) {
        event->reply = "< error could not open bus >";
        return;
    }
    self->mode = LX_SOCKETCAND_BCM;
    event->reply = OK;
}

static void set_mode(struct lx_socketcand *self, const struct words *words,
                     struct lx_socketcand_event *event)
{
    self->mode = words->word[0][0] == 'r' ? LX_SOCKETCAND_RAW : LX_SOCKETCAND_BCM;
    event->reply = OK;
}

static void echo(struct lx_socketcand *self, const struct words *words,
                 struct lx_socketcand_event *event)
{
    (void)self;
    (void)words;
    event->reply = "< echo >";
}

/* Seconds and microseconds between two frames are not kept to: each frame is told. */
static void subscribe(struct lx_socketcand *self, const struct words *words,
                      struct lx_socketcand_event *event)
{
    struct lx_can_wide frame = {.id = 0};
    const bool wanted = words->word[0][0] == 's';
    if (!take_id(words->word[words->count - 1u], &frame) || frame.extended) {
        event->reply = "< error syntax error in subscription >";
        return;
    }
    const uint8_t bit = (uint8_t)(1u << frame.id % 8u);
    uint8_t *byte = &self->wanted[frame.id / 8u];
    *byte = (uint8_t)(wanted ? *byte | bit : *byte & ~bit);
}

static void send_frame(struct lx_socketcand *self, const struct words *words,
                       struct lx_socketcand_event *event)
{
    struct lx_can_wide *frame = &event->frame;
    uint32_t value = 0;
    (void)self;
    bool good = take_id(words->word[1], frame) &&
                take_hex_word(words->word[2], 2, sizeof frame->frame.data, &value) &&
                words->count == 3u + value;
    frame->frame.dlc = (uint8_t)value;
    for (size_t i = 3; good && i < words->count; i++) {
        good = take_hex_word(words->word[i], 2, UINT8_MAX, &value);
        frame->frame.data[i - 3u] = (uint8_t)value;
    }
    frame->frame.id = (uint16_t)(frame->id & ID_MAX);
    event->has_frame = good;
    event->reply = good ? NULL : "< error syntax error in send command >";
}

/* clang-format off */
static const struct {
    const char *name;
    uint8_t modes;
    uint8_t words; /* with the name: at least, ... */
    uint8_t most;  /* ... at most */
    void (*act)(struct lx_socketcand *self, const struct words *words,
                struct lx_socketcand_event *event);
} commands[] = {
    {"open",        NO_BUS,    2, 2,         open_bus},
    {"rawmode",     BCM | RAW, 1, 1,         set_mode},
    {"bcmmode",     BCM | RAW, 1, 1,         set_mode},
    {"send",        BCM | RAW, 3, WORDS_MAX, send_frame},
    {"subscribe",   BCM,       4, 4,         subscribe},
    {"unsubscribe", BCM,       2, 2,         subscribe},
    {"echo",        ANY,       1, 1,         echo},
};
/* clang-format on */

/* false: too many for any command */
static bool split_words(char *text, struct words *words)
{
    char *rest = NULL;
    for (char *word = strtok_r(text, BLANKS, &rest); word != NULL;
         word = strtok_r(NULL, BLANKS, &rest)) {
        if (words->count == WORDS_MAX) {
            return false;
        }
        words->word[words->count++] = word;
    }
    return words->count > 0;
}

static void execute_words(struct lx_socketcand *self, const char *bus,
                          struct lx_socketcand_event *event)
{
    struct words words = {.bus = bus};
    self->text[self->length] = '\0';
    event->reply = "< error unknown command >";
    if (self->overlong || strlen(self->text) != self->length || !split_words(self->text, &words)) {
        return;
    }
    for (size_t i = 0; i < DG_COUNT(commands); i++) {
        if (strcmp(commands[i].name, words.word[0]) == 0 &&
            (commands[i].modes >> self->mode & 1u) != 0 && words.count >= commands[i].words &&
            words.count <= commands[i].most) {
            event->reply = NULL;
            commands[i].act(self, &words, event);
            return;
        }
    }
}

/* What stands between two messages is nothing. */
bool lx_socketcand_feed(struct lx_socketcand *self, const char *bus, uint8_t byte,
                        struct lx_socketcand_event *event)
{
    if (byte == '<') {
        self->inside = true;
        self->overlong = false;
        self->length = 0;
    } else if (self->inside && byte == '>') {
        self->inside = false;
        *event = (struct lx_socketcand_event){.reply = NULL};
        execute_words(self, bus, event);
        return true;
    } else if (self->inside && self->length < LX_SOCKETCAND_MAX) {
        self->text[self->length++] = (char)byte;
    } else {
        self->overlong = true;
    }
    return false;
}

/* The protocol has no remote frames. */
bool lx_socketcand_wants(const struct lx_socketcand *self, const struct lx_can_wide *frame)
{
    const bool subscribed =
        !frame->extended && (self->wanted[frame->id / 8u] >> frame->id % 8u & 1u) != 0;
    return !frame->frame.rtr && (self->mode == LX_SOCKETCAND_RAW || subscribed);
}

size_t lx_socketcand_print(const struct lx_can_wide *frame, dg_ns now,
                           char to[LX_SOCKETCAND_TEXT_MAX])
{
    const size_t size = LX_SOCKETCAND_TEXT_MAX;
    const char *format =
        frame->extended ? "< frame %08lX %llu.%06llu " : "< frame %03lX %llu.%06llu ";
    size_t n = (size_t)snprintf(to, size, format, (unsigned long)frame->id,
                                (unsigned long long)(now / DG_S(1)),
                                (unsigned long long)(now % DG_S(1) / DG_US(1)));
    for (size_t i = 0; i < frame->frame.dlc && i < sizeof frame->frame.data; i++) {
        n += (size_t)snprintf(to + n, size - n, "%02X", frame->frame.data[i]);
    }
    return n + (size_t)snprintf(to + n, size - n, " >");
}
