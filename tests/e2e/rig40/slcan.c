/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "slcan.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#define TEXT_MAX 32u /* tIIIL and 8 bytes in hex */
#define OPEN "S5\rO\r"
#define REFUSED '\a'

static void send_text(const struct master *self, const char *text)
{
    const size_t n = strlen(text);
    if (write(self->fd, text, n) != (ssize_t)n) {
        die(self->where);
    }
}

void slcan_open(struct master *self)
{
    struct termios line;
    self->fd = open(self->where, O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (self->fd < 0 || tcgetattr(self->fd, &line) != 0) {
        die(self->where);
    }
    cfmakeraw(&line);
    if (tcsetattr(self->fd, TCSANOW, &line) != 0) {
        die(self->where);
    }
    send_text(self, OPEN);
}

void slcan_send(const struct master *self, const struct can_frame *frame)
{
    char text[TEXT_MAX];
    int n = snprintf(text, sizeof text, "t%03X%u", (unsigned)frame->can_id, frame->can_dlc);
    for (unsigned i = 0; i < frame->can_dlc; i++) {
        n += snprintf(&text[n], sizeof text - (size_t)n, "%02X", frame->data[i]);
    }
    (void)snprintf(&text[n], sizeof text - (size_t)n, "\r");
    send_text(self, text);
}

/* A line without its end in self->line; the adapter acknowledges with an empty one or a "z". What
   has come of a line by `end` stays for the next call. */
static bool read_line(struct master *self, int64_t end)
{
    while (readable(self->fd, end)) {
        char c = '\0';
        if (read(self->fd, &c, 1) != 1) {
            die(self->where);
        }
        if (c == REFUSED || self->line_size == sizeof self->line - 1u) {
            errno = EPROTO;
            die(self->where);
        }
        if (c == '\r') {
            self->line[self->line_size] = '\0';
            self->line_size = 0;
            return true;
        }
        self->line[self->line_size++] = c;
    }
    return false;
}

bool slcan_take(struct master *self, struct can_frame *frame, int64_t end)
{
    const char *line = self->line;
    while (read_line(self, end)) {
        unsigned n = 0;
        int at = 0;
        if (sscanf(line, "t%3x%1u%n", &frame->can_id, &n, &at) != 2) {
            continue;
        }
        frame->can_dlc = (uint8_t)n;
        for (unsigned i = 0; i < n && i < sizeof frame->data; i++, at += 2) {
            if (sscanf(&line[at], "%2hhx", &frame->data[i]) != 1) {
                errno = EPROTO;
                die(line);
            }
        }
        return true;
    }
    return false;
}
