/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "verify_frames.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "timer.h"
#include "verify_silkit.h"
#include "verify_stream.h"

/* How long a socketcand may take for an answer when a bus is opened. */
#define GREETING_MAX DG_S(2)
/* Messages of a socketcand that are read for one answer. */
#define MESSAGES_MAX 100u

/* What frames look like in bytes. */
struct verify_frames_form {
    const char *ends;  /* of a line */
    const char *leave; /* what is sent at the end */
    /* @return the length of the text in `to`, 0: it has no such frames */
    size_t (*print)(const struct dg_can_frame *frame, char to[VERIFY_LINE_MAX]);
    /* @return whether it is a frame with 11 bits */
    bool (*parse)(const char *line, struct dg_can_frame *to);
};

/* Close, 250 kBd, open: an adapter may still be open from somebody else's work. */
static const char beginning[] = "\rC\rS5\rO\r";

static int open_socket(struct verify_frames *self, const char *where, struct lx_error *error)
{
    struct sockaddr_can address = {.can_family = AF_CAN};
    address.can_ifindex = (int)if_nametoindex(where);
    self->stream.fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    if (self->stream.fd < 0 || address.can_ifindex == 0 ||
        bind(self->stream.fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        return lx_fail(error, "%s: %s", where, strerror(errno));
    }
    return 0;
}

/* So many hexadecimal digits. @return whether they are there */
static bool parse_hex(const char *text, size_t digits, uint32_t *value)
{
    static const char all[] = "0123456789ABCDEF";
    *value = 0;
    for (size_t i = 0; i < digits; i++) {
        const char *digit = text[i] == '\0' ? NULL : strchr(all, toupper((unsigned char)text[i]));
        if (digit == NULL) {
            return false;
        }
        *value = *value << 4 | (uint32_t)(digit - all);
    }
    return true;
}

/* As many bytes as the frame has, two digits each. */
static bool parse_data(const char *at, struct dg_can_frame *to)
{
    for (uint8_t i = 0; i < to->dlc; i++, at += 2) {
        uint32_t byte = 0;
        if (!parse_hex(at, 2, &byte)) {
            return false;
        }
        to->data[i] = (uint8_t)byte;
    }
    return true;
}

/* --- SLCAN --- */

/* "t63F840001000...", "r73F1" */
static bool parse_line(const char *line, struct dg_can_frame *to)
{
    uint32_t id = 0;
    uint32_t length = 0;
    if ((line[0] != 't' && line[0] != 'r') || !parse_hex(line + 1, 3, &id) ||
        !parse_hex(line + 4, 1, &length) || length > 8 || id > 0x7FFu) {
        return false;
    }
    *to = (struct dg_can_frame){.id = (uint16_t)id, .dlc = (uint8_t)length, .rtr = line[0] == 'r'};
    return to->rtr || parse_data(line + 5, to);
}

static size_t print_line(const struct dg_can_frame *frame, char to[VERIFY_LINE_MAX])
{
    int n = snprintf(to, VERIFY_LINE_MAX, "%c%03X%u", frame->rtr ? 'r' : 't', frame->id,
                     frame->dlc & 0xFu);
    for (uint8_t i = 0; i < frame->dlc && !frame->rtr; i++) {
        n += snprintf(to + n, VERIFY_LINE_MAX - (size_t)n, "%02X", frame->data[i]);
    }
    to[n++] = '\r';
    return (size_t)n;
}

static const struct verify_frames_form slcan = {
    .ends = "\r\a", .leave = "C\r", .print = print_line, .parse = parse_line};

/* --- socketcand --- */

/* "< frame 5BF 123.456789 4300100096010200 " */
static bool parse_message(const char *text, struct dg_can_frame *to)
{
    static const char word[] = "frame ";
    static const char digits[] = "0123456789ABCDEFabcdef";
    text += strspn(text, "< \r\n");
    if (strncmp(text, word, sizeof word - 1u) != 0) {
        return false;
    }
    text += sizeof word - 1u;
    const size_t n = strspn(text, digits);
    const unsigned long id = strtoul(text, NULL, 16);
    text += n;
    text += strspn(text, " ");
    text += strcspn(text, " "); /* when it came */
    text += strspn(text, " ");
    const size_t length = strspn(text, digits) / 2u;
    *to = (struct dg_can_frame){.id = (uint16_t)id, .dlc = (uint8_t)length};
    return n >= 1 && n <= 3 && id <= 0x7FFu && length <= 8 && parse_data(text, to);
}

static size_t print_message(const struct dg_can_frame *frame, char to[VERIFY_LINE_MAX])
{
    if (frame->rtr) {
        return 0;
    }
    int n = snprintf(to, VERIFY_LINE_MAX, "< send %03X %u", frame->id, frame->dlc & 0xFu);
    for (uint8_t i = 0; i < frame->dlc; i++) {
        n += snprintf(to + n, VERIFY_LINE_MAX - (size_t)n, " %02X", frame->data[i]);
    }
    n += snprintf(to + n, VERIFY_LINE_MAX - (size_t)n, " >");
    return (size_t)n;
}

static const struct verify_frames_form socketcand = {
    .ends = ">", .leave = "", .print = print_message, .parse = parse_message};

/* --- lines --- */

/* Whether this byte completes a line. What is too long is no line. */
static bool feed_byte(struct verify_frames *self, uint8_t byte)
{
    if (byte != '\0' && strchr(self->form->ends, byte) != NULL) {
        self->line[self->length] = '\0';
        self->length = 0;
        return true;
    }
    self->length = self->length + 1u < sizeof self->line ? self->length : 0;
    self->line[self->length++] = (char)byte;
    return false;
}

/* The next line is in self->line. @return 1, 0: none came, -1: the wire is gone */
static int receive_line(struct verify_frames *self, dg_ns until)
{
    for (bool late = false;; late = lx_real_now() > until) {
        while (self->seen < self->count) {
            if (feed_byte(self, self->bytes[self->seen++])) {
                return 1;
            }
        }
        if (late) {
            return 0;
        }
        const long n = verify_stream_receive(&self->stream, until, self->bytes, sizeof self->bytes);
        self->seen = 0;
        self->count = n > 0 ? (size_t)n : 0;
        if (n <= 0) {
            return (int)n;
        }
    }
}

/* --- opening --- */

static int open_adapter(struct verify_frames *self, const char *where, struct lx_error *error)
{
    static const struct lx_uart uart = {.baud = 115200, .parity = 'N'};
    self->form = &slcan;
    if (verify_stream_open(&self->stream, where, &uart, error) != 0) {
        return -1;
    }
    return verify_stream_send(&self->stream, beginning, sizeof beginning - 1u) == 0
               ? 0
               : lx_fail(error, "%s: the adapter accepts no data", where);
}

/* @return false: another answer, or none */
static bool await_word(struct verify_frames *self, const char *word)
{
    const dg_ns until = lx_real_now() + GREETING_MAX;
    for (unsigned i = 0; i < MESSAGES_MAX && receive_line(self, until) > 0; i++) {
        const char *text = self->line + strspn(self->line, "< \r\n");
        if (strncmp(text, word, strlen(word)) == 0) {
            return true;
        }
    }
    return false;
}

/* HOST:PORT[,BUS]. The server says what it is, opens the bus, and tells all its frames. */
static int open_server(struct verify_frames *self, const char *where, struct lx_error *error)
{
    const char *comma = strchr(where, ',');
    char address[300];
    char text[80];
    (void)snprintf(address, sizeof address, "tcp:%.*s",
                   (int)(comma == NULL ? strlen(where) : (size_t)(comma - where)), where);
    (void)snprintf(text, sizeof text, "< open %s >", comma == NULL ? "can0" : comma + 1);
    self->form = &socketcand;
    if (verify_stream_open(&self->stream, address, NULL, error) != 0) {
        return -1;
    }
    return await_word(self, "hi") && verify_stream_send(&self->stream, text, strlen(text)) == 0 &&
                   await_word(self, "ok") &&
                   verify_stream_send(&self->stream, "< rawmode >", 11) == 0 &&
                   await_word(self, "ok")
               ? 0
               : lx_refuse(error, "expected the name of its bus, as in HOST:PORT,vcan0",
                           "%s: no socketcand that opens this bus", where);
}

int verify_frames_open(struct verify_frames *self, const struct options *options,
                       struct lx_error *error)
{
    const char *kind = options->wire->name;
    static const struct {
        const char *kind;
        int (*open)(struct verify_frames *self, const char *where, struct lx_error *error);
    } kinds[] = {{"can", open_socket}, {"slcan", open_adapter}, {"socketcand", open_server}};
    *self = (struct verify_frames){.stream = {.fd = -1}};
    if (verify_silkit_is(options)) {
        return verify_stream_join(&self->stream, options, error);
    }
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(kind, kinds[i].kind) == 0) {
            return kinds[i].open(self, options->where, error);
        }
    }
    return lx_refuse(error, "expected --can, --slcan, --socketcand or --silkit",
                     "verify cannot use --%s", kind);
}

/* --- frames --- */

int verify_frames_send(struct verify_frames *self, const struct dg_can_frame *frame)
{
    struct can_frame raw = {.can_id = frame->id, .can_dlc = frame->dlc};
    char line[VERIFY_LINE_MAX];
    if (self->form != NULL) {
        const size_t n = self->form->print(frame, line);
        return n == 0 ? 0 : verify_stream_send(&self->stream, line, n);
    }
    if (self->stream.silkit != NULL) {
        return verify_stream_send(&self->stream, frame, sizeof *frame);
    }
    raw.can_id |= frame->rtr ? CAN_RTR_FLAG : 0u;
    memcpy(raw.data, frame->data, sizeof raw.data);
    return verify_stream_send(&self->stream, &raw, sizeof raw);
}

bool verify_frames_has_remote(const struct verify_frames *self)
{
    return self->form != &socketcand;
}

int verify_frames_receive(struct verify_frames *self, dg_ns until, struct dg_can_frame *to)
{
    struct can_frame raw;
    while (self->form != NULL) {
        const int result = receive_line(self, until);
        if (result <= 0 || self->form->parse(self->line, to)) {
            return result;
        }
        if (lx_real_now() > until) {
            return 0;
        }
    }
    if (self->stream.silkit != NULL) {
        const long came = verify_stream_receive(&self->stream, until, to, sizeof *to);
        return came > 0 ? 1 : (int)came;
    }
    const long n = verify_stream_receive(&self->stream, until, &raw, sizeof raw);
    if (n != (long)sizeof raw || (raw.can_id & (CAN_EFF_FLAG | CAN_ERR_FLAG)) != 0 ||
        raw.can_dlc > 8) {
        return n < 0 ? -1 : 0;
    }
    *to = (struct dg_can_frame){
        .id = (uint16_t)(raw.can_id & CAN_SFF_MASK),
        .dlc = raw.can_dlc,
        .rtr = (raw.can_id & CAN_RTR_FLAG) != 0,
    };
    memcpy(to->data, raw.data, sizeof to->data);
    return 1;
}

void verify_frames_close(struct verify_frames *self)
{
    if (self->form != NULL && self->stream.fd >= 0) {
        (void)verify_stream_send(&self->stream, self->form->leave, strlen(self->form->leave));
    }
    verify_stream_close(&self->stream);
}
