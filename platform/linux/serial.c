/* SPDX-License-Identifier: MIT */
/*
 * What a pty and a UART have in common: non-blocking reads in chunks, replies that keep the time of
 * the line, and half duplex. While a reply is on the line, what comes in has collided with it.
 */
#define _GNU_SOURCE
#include "serial.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <termios.h>
#include <unistd.h>

/* Bytes read at once; a flood is taken in pieces of this, between which deadlines get their turn.
 */
#define CHUNK 4096u

/* clang-format off */
static const struct {
    uint32_t baud;
    speed_t speed;
} speeds[] = {
    {300, B300},     {600, B600},     {1200, B1200},   {2400, B2400},     {4800, B4800},
    {9600, B9600},   {19200, B19200}, {38400, B38400}, {57600, B57600},   {115200, B115200},
    {230400, B230400},
};
/* clang-format on */
#define SPEED_COUNT (sizeof speeds / sizeof speeds[0])

uint32_t lx_baud_of_speed(unsigned long speed)
{
    for (size_t i = 0; i < SPEED_COUNT; i++) {
        if (speeds[i].speed == speed) {
            return speeds[i].baud;
        }
    }
    return 0;
}

unsigned long lx_speed_of_baud(uint32_t baud)
{
    for (size_t i = 0; i < SPEED_COUNT; i++) {
        if (speeds[i].baud == baud) {
            return speeds[i].speed;
        }
    }
    return 0;
}

/* A full buffer, or no line at all, loses characters as a wire does. */
static void put(struct lx_serial *self, const uint8_t *bytes, size_t n)
{
    while (n > 0) {
        const ssize_t done = self->fd < 0 ? -1 : write(self->fd, bytes, n);
        if (done < 0 && self->fd >= 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            self->counters.lost += n;
            return;
        }
        bytes += done;
        n -= (size_t)done;
    }
}

static void on_character_over(void *ctx, dg_ns now)
{
    struct lx_serial *self = ctx;
    const uint8_t *bytes = NULL;
    const size_t n = lx_line_take(&self->line, now, &bytes);
    put(self, bytes, n);
    lx_timer_at(&self->timer, lx_line_next(&self->line));
}

static int on_readable(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_serial *self = ctx;
    uint8_t bytes[CHUNK];
    (void)source;
    /* One chunk for each turn of the loop; the rest is still readable in the next one. */
    const ssize_t n = read(fd, bytes, sizeof bytes);
    const int reason = n < 0 ? errno : 0;
    if (n > 0) {
        self->ops->received(self, lx_now(), bytes, (size_t)n);
        return 0;
    }
    const bool nothing_yet = n < 0 && (reason == EAGAIN || reason == EINTR);
    if (!nothing_yet || (events & (EPOLLHUP | EPOLLERR)) != 0) {
        self->ops->gone(self, nothing_yet ? 0 : reason);
    }
    return 0;
}

int lx_serial_init(struct lx_serial *self, const struct lx_serial_ops *ops,
                   const struct lx_serial_setup *setup, struct lx_error *error)
{
    self->ops = ops;
    self->setup = *setup;
    self->uart = setup->uart;
    self->fd = -1;
    lx_line_set(&self->line, &setup->uart);
    const int result = lx_timer_open(&self->timer, setup->event, on_character_over, self);
    return result < 0 ? lx_fail(error, "no timer: %s", strerror(-result)) : 0;
}

int lx_serial_watch(struct lx_serial *self)
{
    return sd_event_add_io(self->setup.event, &self->io, self->fd, EPOLLIN, on_readable, self);
}

void lx_serial_unwatch(struct lx_serial *self)
{
    self->io = sd_event_source_disable_unref(self->io);
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
}

void lx_serial_close(struct lx_serial *self)
{
    if (self == NULL) {
        return;
    }
    self->ops->close(self);
    lx_serial_unwatch(self);
    lx_timer_close(&self->timer);
    free(self);
}

void lx_serial_set(struct lx_serial *self, const struct dg_hf_uart *uart)
{
    self->uart = *uart;
    lx_line_set(&self->line, uart);
    if (self->ops->apply != NULL) {
        self->ops->apply(self);
    }
}

void lx_serial_rx(struct lx_serial *self, dg_ns now, const struct lx_character *character)
{
    if (self->pace != LX_PACE_NONE && lx_line_busy(&self->line, now)) {
        self->counters.collided++;
        return;
    }
    self->setup.rx(self->setup.ctx, now, character);
}

void lx_serial_send(struct lx_serial *self, dg_ns now, const uint8_t *bytes, size_t n)
{
    lx_line_start(&self->line, now, bytes, n);
    if (self->pace == LX_PACE_TIMER) {
        lx_timer_at(&self->timer, lx_line_next(&self->line));
        return;
    }
    const uint8_t *all = NULL;
    const size_t count = lx_line_take_all(&self->line, &all);
    put(self, all, count);
}
