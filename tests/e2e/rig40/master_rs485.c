/* SPDX-License-Identifier: MIT */
/* A drive on an RS485 line: one encoder after the other. */
#define _GNU_SOURCE
#include "masters.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#define PAUSE_BITS 48 /* amply the 44 that end a frame */
#define READ_POSITION 0x42u
#define READ_STATUS 0x50u
#define WARNING 0x80u
#define ERROR_REPLY_BYTES 4u
#define POSITION_REPLY_BYTES 7u
#define QUIET (50 * NS_PER_MS)

static bool intact(const uint8_t *bytes, size_t n)
{
    uint8_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum ^= bytes[i];
    }
    return sum == 0;
}

/* A reply of `length` bytes, or of an error. @return its bytes; 0: nothing came */
static size_t read_reply(const struct master *self, uint8_t *bytes, size_t length, int64_t end)
{
    size_t n = 0;
    while (n < length && readable(self->fd, end)) {
        if (read(self->fd, &bytes[n], 1) != 1) {
            die(self->where);
        }
        n++;
        if (n == 2 && (bytes[1] & ~WARNING) == READ_STATUS) {
            length = ERROR_REPLY_BYTES;
        }
    }
    return n;
}

/* Until nothing comes any more. */
static void let_quiet(const struct master *self)
{
    uint8_t byte;
    while (readable(self->fd, now_ns() + QUIET)) {
        if (read(self->fd, &byte, 1) != 1) {
            die(self->where);
        }
    }
}

/* @return bytes of an intact reply, else 0 */
static size_t exchange(struct master *self, struct device *device, uint8_t command, uint8_t *reply)
{
    const uint8_t address = (uint8_t)device->address;
    const uint8_t request[] = {address, command, address ^ command};
    const size_t length = command == READ_STATUS ? ERROR_REPLY_BYTES : POSITION_REPLY_BYTES;
    const int64_t from = now_ns();
    if (write(self->fd, request, sizeof request) != (ssize_t)sizeof request) {
        die(self->where);
    }
    const size_t n = read_reply(self, reply, length, from + self->patience);
    if (n == 0) {
        lose(self, device);
        return 0;
    }
    if (n < ERROR_REPLY_BYTES || reply[0] != address || !intact(reply, n)) {
        garble(self, device);
        let_quiet(self);
        return 0;
    }
    took(self, from);
    sleep_until(now_ns() + self->pause);
    return n;
}

/* Why the warning bit is set, until it is not. */
static void empty_queue(struct master *self, struct device *device, uint8_t *reply)
{
    while ((reply[1] & WARNING) != 0 && exchange(self, device, READ_STATUS, reply) != 0) {
        say(device->name, "warning %02Xh", reply[2]);
    }
}

static void ask_rs485(struct master *self, struct device *device)
{
    uint8_t reply[POSITION_REPLY_BYTES];
    char text[STATE_MAX];
    const int64_t from = now_ns();
    const size_t n = exchange(self, device, READ_POSITION, reply);
    if (n == 0) {
        return;
    }
    if (n == ERROR_REPLY_BYTES) {
        (void)snprintf(text, sizeof text, "error %02Xh", reply[2]);
        become(device, text);
    } else {
        const uint64_t position = (uint64_t)reply[2] << 24 | (uint64_t)reply[3] << 16 |
                                  (uint64_t)reply[4] << 8 | reply[5];
        if (check(self, device, position, from)) {
            become(device, "ok");
        }
    }
    empty_queue(self, device, reply);
}

static const struct {
    const char *told; /* behind the terminal; the first one where nothing is */
    int baud;
    speed_t speed;
} speeds[] = {
    {"", 9600, B9600},
    {"@38400", 38400, B38400},
};

/* Open the terminal of `where`. @return its speed */
static speed_t open_line(struct master *self)
{
    char path[LINE_SIZE];
    const size_t n = strcspn(self->where, "@");
    size_t i = 0;
    while (strcmp(speeds[i].told, &self->where[n]) != 0) {
        if (++i == sizeof speeds / sizeof speeds[0]) {
            errno = EINVAL;
            die(self->where);
        }
    }
    (void)snprintf(path, sizeof path, "%.*s", (int)n, self->where);
    self->fd = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
    self->pause = PAUSE_BITS * NS_PER_S / speeds[i].baud;
    return speeds[i].speed;
}

void run_rs485(struct master *self)
{
    struct termios line;
    const speed_t speed = open_line(self);
    if (self->fd < 0 || tcgetattr(self->fd, &line) != 0) {
        die(self->where);
    }
    cfmakeraw(&line);
    line.c_cflag |= CLOCAL | CREAD; /* a pseudo-terminal has no parity */
    (void)cfsetspeed(&line, speed);
    if (tcsetattr(self->fd, TCSANOW, &line) != 0) {
        die(self->where);
    }
    for (unsigned i = 0; goes_on(self) && self->count > 0; i++) {
        ask_rs485(self, &self->device[i % self->count]);
    }
}
