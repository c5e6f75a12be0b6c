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
#include "verify_stream.h"

/* Close, 250 kBd, open: an adapter may still be open from somebody else's work. */
static const char beginning[] = "\rC\rS5\rO\r";

static int open_socket(struct verify_frames *self, const char *where, struct lx_error *error)
{
    struct sockaddr_can address = {.can_family = AF_CAN};
    address.can_ifindex = (int)if_nametoindex(where);
    self->fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    if (self->fd < 0 || address.can_ifindex == 0 ||
        bind(self->fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        return lx_fail(error, "%s: %s", where, strerror(errno));
    }
    return 0;
}

static int open_adapter(struct verify_frames *self, const char *where, struct lx_error *error)
{
    static const struct lx_uart uart = {.baud = 115200, .parity = 'N'};
    self->adapter = true;
    self->fd = verify_stream_open(where, &uart, error);
    if (self->fd < 0) {
        return -1;
    }
    return verify_stream_send(self->fd, beginning, sizeof beginning - 1u) == 0
               ? 0
               : lx_fail(error, "%s: the adapter takes nothing", where);
}

int verify_frames_open(struct verify_frames *self, const char *kind, const char *where,
                       struct lx_error *error)
{
    *self = (struct verify_frames){.fd = -1};
    if (strcmp(kind, "slcan") == 0) {
        return open_adapter(self, where, error);
    }
    if (strcmp(kind, "can") == 0) {
        return open_socket(self, where, error);
    }
    return lx_refuse(error, "expected --can or --slcan", "verify cannot use --%s", kind);
}

int verify_frames_send(struct verify_frames *self, const struct dg_can_frame *frame)
{
    struct can_frame raw = {.can_id = frame->id, .can_dlc = frame->dlc};
    char line[VERIFY_LINE_MAX];
    if (!self->adapter) {
        raw.can_id |= frame->rtr ? CAN_RTR_FLAG : 0u;
        memcpy(raw.data, frame->data, sizeof raw.data);
        return verify_stream_send(self->fd, &raw, sizeof raw);
    }
    int n = snprintf(line, sizeof line, "%c%03X%u", frame->rtr ? 'r' : 't', frame->id, frame->dlc);
    for (uint8_t i = 0; i < frame->dlc && !frame->rtr; i++) {
        n += snprintf(line + n, sizeof line - (size_t)n, "%02X", frame->data[i]);
    }
    line[n++] = '\r';
    return verify_stream_send(self->fd, line, (size_t)n);
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

/* "t63F840001000...", "r73F1". @return whether it is a frame with 11 bits */
static bool parse_line(const char *line, struct dg_can_frame *to)
{
    uint32_t id = 0;
    uint32_t length = 0;
    if ((line[0] != 't' && line[0] != 'r') || !parse_hex(line + 1, 3, &id) ||
        !parse_hex(line + 4, 1, &length) || length > 8 || id > 0x7FFu) {
        return false;
    }
    *to = (struct dg_can_frame){.id = (uint16_t)id, .dlc = (uint8_t)length, .rtr = line[0] == 'r'};
    const char *at = line + 5;
    for (uint32_t i = 0; i < length && !to->rtr; i++, at += 2) {
        uint32_t byte = 0;
        if (!parse_hex(at, 2, &byte)) {
            return false;
        }
        to->data[i] = (uint8_t)byte;
    }
    return true;
}

/* Whether this byte completes a frame. What is too long is no line of an adapter. */
static bool feed_byte(struct verify_frames *self, uint8_t byte, struct dg_can_frame *to)
{
    if (byte == '\r' || byte == '\a') {
        self->line[self->length] = '\0';
        self->length = 0;
        return parse_line(self->line, to);
    }
    self->length = self->length + 1u < sizeof self->line ? self->length : 0;
    self->line[self->length++] = (char)byte;
    return false;
}

static int receive_line(struct verify_frames *self, dg_ns until, struct dg_can_frame *to)
{
    for (;;) {
        while (self->seen < self->count) {
            if (feed_byte(self, self->bytes[self->seen++], to)) {
                return 1;
            }
        }
        const long n = verify_stream_receive(self->fd, until, self->bytes, sizeof self->bytes);
        self->seen = 0;
        self->count = n > 0 ? (size_t)n : 0;
        if (n <= 0 || (lx_real_now() > until && n == 0)) {
            return (int)n;
        }
    }
}

int verify_frames_receive(struct verify_frames *self, dg_ns until, struct dg_can_frame *to)
{
    struct can_frame raw;
    if (self->adapter) {
        return receive_line(self, until, to);
    }
    const long n = verify_stream_receive(self->fd, until, &raw, sizeof raw);
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
    if (self->adapter && self->fd >= 0) {
        (void)verify_stream_send(self->fd, "C\r", 2);
    }
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
}
