/* SPDX-License-Identifier: MIT */
/*
 * One row for each command: in which states of the channel it is allowed, and what it does. All
 * that is not in the table, too long, too short or not allowed is answered with BEL.
 */
#include "drehgeber/slcan.h"

#define OK "\r"
#define BEL "\a"

/* Stamps count to a minute. */
#define STAMP_RANGE_MS 60000u

#define CAN_ID_MAX 0x7FFu
#define EXTENDED_ID_MAX 0x1FFFFFFFu

/* States a command is allowed in. */
enum {
    CLOSED = 1 << DG_SLCAN_CLOSED,
    OPEN = 1 << DG_SLCAN_OPEN,
    LISTENING = 1 << DG_SLCAN_LISTENING,
    ANY = CLOSED | OPEN | LISTENING,
};

/* The value of a hexadecimal digit of either case; 16: it is none. */
static uint32_t digit(char c)
{
    const char lower = (char)(c | 0x20);
    if (c >= '0' && c <= '9') {
        return (uint32_t)(c - '0');
    }
    return lower >= 'a' && lower <= 'f' ? (uint32_t)(lower - 'a') + 10u : 16u;
}

/* The value of `n` hexadecimal digits; false when there are not as many. */
static bool take_hex(const char **at, const char *end, uint8_t n, uint32_t *value)
{
    *value = 0;
    for (; n > 0; n--) {
        const uint32_t next = *at == end ? 16u : digit(**at);
        if (next > 0xFu) {
            return false;
        }
        *value = *value << 4 | next;
        (*at)++;
    }
    return true;
}

/* Length and data; a remote frame has none. The line must end there. */
static bool take_data(const char *at, const char *end, struct dg_can_frame *frame)
{
    uint32_t value = 0;
    if (!take_hex(&at, end, 1, &value) || value > sizeof frame->data) {
        return false;
    }
    frame->dlc = (uint8_t)value;
    for (uint8_t i = 0; !frame->rtr && i < frame->dlc; i++) {
        if (!take_hex(&at, end, 2, &value)) {
            return false;
        }
        frame->data[i] = (uint8_t)value;
    }
    return at == end;
}

/* t r: a frame for the encoder. T R: an extended frame, which is on the bus but means nothing. */
static const char *send(struct dg_slcan *self, struct dg_slcan_event *event)
{
    const char *at = self->line + 1;
    const char *end = self->line + self->length;
    const bool extended = self->line[0] == 'T' || self->line[0] == 'R';
    uint32_t id = 0;
    event->frame.rtr = self->line[0] == 'r' || self->line[0] == 'R';
    if (!take_hex(&at, end, extended ? 8 : 3, &id) ||
        id > (extended ? EXTENDED_ID_MAX : CAN_ID_MAX) || !take_data(at, end, &event->frame)) {
        return NULL;
    }
    event->frame.id = (uint16_t)(id & CAN_ID_MAX);
    event->has_frame = !extended;
    event->extended = extended;
    return extended ? "Z" OK : "z" OK;
}

static const char *set_rate(struct dg_slcan *self, struct dg_slcan_event *event)
{
    static const uint16_t kbaud[] = {10, 20, 50, 100, 125, 250, 500, 800, 1000};
    const unsigned rate = (unsigned)(self->line[1] - '0');
    (void)event;
    if (self->length != 2 || rate >= DG_COUNT(kbaud)) {
        return NULL;
    }
    self->kbaud = kbaud[rate];
    return OK;
}

static const char *set_stamps(struct dg_slcan *self, struct dg_slcan_event *event)
{
    (void)event;
    if (self->length != 2 || (self->line[1] != '0' && self->line[1] != '1')) {
        return NULL;
    }
    self->stamps = self->line[1] == '1';
    return OK;
}

static const char *set_channel(struct dg_slcan *self, struct dg_slcan_event *event)
{
    (void)event;
    if (self->length != 1) {
        return NULL;
    }
    self->state = self->line[0] == 'O'   ? DG_SLCAN_OPEN
                  : self->line[0] == 'L' ? DG_SLCAN_LISTENING
                                         : DG_SLCAN_CLOSED;
    return OK;
}

/* No error of an adapter happens here; its versions and number are made up. */
static const char *inquire(struct dg_slcan *self, struct dg_slcan_event *event)
{
    (void)event;
    if (self->length != 1) {
        return NULL;
    }
    return self->line[0] == 'F' ? "F00" OK : self->line[0] == 'V' ? "V1010" OK : "NDG01" OK;
}

/* clang-format off */
static const struct {
    char letter;
    uint8_t states;
    const char *(*act)(struct dg_slcan *self, struct dg_slcan_event *event); /* NULL: refused */
} commands[] = {
    {'S', CLOSED,           set_rate},
    {'Z', CLOSED,           set_stamps},
    {'O', CLOSED,           set_channel},
    {'L', CLOSED,           set_channel},
    {'C', OPEN | LISTENING, set_channel},
    {'t', OPEN,             send},
    {'T', OPEN,             send},
    {'r', OPEN,             send},
    {'R', OPEN,             send},
    {'F', OPEN | LISTENING, inquire},
    {'V', ANY,              inquire},
    {'N', ANY,              inquire},
};
/* clang-format on */
#define COMMAND_COUNT DG_COUNT(commands)

static const char *run_command(struct dg_slcan *self, struct dg_slcan_event *event)
{
    for (size_t i = 0; i < COMMAND_COUNT; i++) {
        if (commands[i].letter == self->line[0] && (commands[i].states >> self->state & 1u) != 0) {
            return commands[i].act(self, event);
        }
    }
    return NULL;
}

/* An empty line is how a master makes sure that its next one is read from the start. */
static const char *answer_line(struct dg_slcan *self, struct dg_slcan_event *event)
{
    if (self->overlong) {
        return BEL;
    }
    if (self->length == 0) {
        return OK;
    }
    const char *reply = run_command(self, event);
    return reply == NULL ? BEL : reply;
}

bool dg_slcan_feed(struct dg_slcan *self, uint8_t byte, struct dg_slcan_event *event)
{
    if (byte != '\r') {
        self->overlong = self->overlong || self->length == sizeof self->line;
        if (!self->overlong) {
            self->line[self->length++] = (char)byte;
        }
        return false;
    }
    *event = (struct dg_slcan_event){.has_frame = false};
    event->reply = answer_line(self, event);
    dg_slcan_resync(self);
    return true;
}

void dg_slcan_resync(struct dg_slcan *self)
{
    self->length = 0;
    self->overlong = false;
}

/* The last `n` hexadecimal digits of a value; returns where the next ones go. */
static char *put_hex_digits(char *to, uint32_t value, uint8_t n)
{
    for (uint8_t i = n; i > 0; i--) {
        to[i - 1u] = "0123456789ABCDEF"[value & 0xFu];
        value >>= 4;
    }
    return to + n;
}

size_t dg_slcan_print(const struct dg_slcan *self, const struct dg_can_frame *frame, uint64_t ms,
                      char *text)
{
    char *at = text;
    *at++ = frame->rtr ? 'r' : 't';
    at = put_hex_digits(at, frame->id & CAN_ID_MAX, 3);
    at = put_hex_digits(at, frame->dlc, 1);
    for (uint8_t i = 0; !frame->rtr && i < frame->dlc && i < sizeof frame->data; i++) {
        at = put_hex_digits(at, frame->data[i], 2);
    }
    if (self->stamps) {
        at = put_hex_digits(at, (uint32_t)(ms % STAMP_RANGE_MS), 4);
    }
    *at++ = '\r';
    *at = '\0';
    return (size_t)(at - text);
}
