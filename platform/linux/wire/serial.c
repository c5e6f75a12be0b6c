/* SPDX-License-Identifier: MIT */
/*
 * What a pty and a UART have in common: non-blocking reads in chunks, writes that lose what nobody
 * takes, and coming back.
 */
#define _GNU_SOURCE
#include "serial.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <termios.h>
#include <unistd.h>

/* How often a port that has gone is looked for. */
#define REOPEN DG_S(1)

/* clang-format off */
static const struct {
    uint32_t baud;
    speed_t speed;
} speeds[] = {
    {300, B300},         {600, B600},         {1200, B1200},       {2400, B2400},
    {4800, B4800},       {9600, B9600},       {19200, B19200},     {38400, B38400},
    {57600, B57600},     {115200, B115200},   {230400, B230400},   {460800, B460800},
    {500000, B500000},   {576000, B576000},   {921600, B921600},   {1000000, B1000000},
    {1152000, B1152000}, {1500000, B1500000}, {2000000, B2000000}, {2500000, B2500000},
    {3000000, B3000000}, {3500000, B3500000}, {4000000, B4000000},
};
/* clang-format on */
#define SPEED_COUNT DG_COUNT(speeds)

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

bool lx_serial_up(const struct lx_serial *self)
{
    return self->fd >= 0;
}

size_t lx_serial_send(struct lx_serial *self, const uint8_t *bytes, size_t n)
{
    size_t sent = 0;
    if (self->ops->send != NULL) {
        return self->ops->send(self, bytes, n);
    }
    while (sent < n && lx_serial_up(self)) {
        const ssize_t done = write(self->fd, bytes + sent, n - sent);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            break;
        }
        sent += (size_t)done;
    }
    return sent;
}

/* A full buffer, or no port at all, loses characters as a wire does. */
void lx_serial_put(struct lx_serial *self, const uint8_t *bytes, size_t n)
{
    self->counters.lost += n - lx_serial_send(self, bytes, n);
}

static void shut_port(struct lx_serial *self)
{
    if (self->ops->shut != NULL) {
        self->ops->shut(self);
    }
    self->io = sd_event_source_disable_unref(self->io);
    self->count = 0;
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
}

static void try_again(void *ctx, dg_ns now)
{
    struct lx_serial *self = ctx;
    struct lx_error ignored;
    if (self->ops->open(self, &ignored) != 0) {
        shut_port(self);
        lx_timer_at(&self->reopen, dg_after(now, REOPEN));
        return;
    }
    lx_note(self->setup.say, "%s: back",
            self->setup.where == NULL ? self->address : self->setup.where);
    if (self->setup.back != NULL) {
        self->setup.back(self->setup.ctx);
    }
}

/* `reason` is an errno, 0 for a hang-up. */
static void close_gone_port(struct lx_serial *self, int reason)
{
    const bool lasting = self->ops->lasting == NULL || self->ops->lasting(self);
    lx_complain("%s: gone (%s); %s", self->address, reason == 0 ? "hung up" : strerror(reason),
                lasting ? self->ops->again
                        : "the system may give its name to another pty, so start again");
    shut_port(self);
    if (lasting) {
        lx_timer_at(&self->reopen, dg_after(lx_now(), REOPEN));
    }
}

/* Until somebody pauses in the middle: then the rest waits. */
static void hand_over_characters(struct lx_serial *self, dg_ns now)
{
    while (self->count > 0 && !self->paused) {
        struct lx_character character = {.byte = self->chunk[self->first++]};
        self->more = --self->count;
        if (self->ops->decode == NULL || self->ops->decode(self, character.byte, &character)) {
            self->setup.rx(self->setup.ctx, now, &character);
        }
    }
}

void lx_serial_pause(struct lx_serial *self, bool paused)
{
    self->paused = paused;
    hand_over_characters(self, lx_now());
    if (self->io != NULL) {
        (void)sd_event_source_set_enabled(self->io, self->paused ? SD_EVENT_OFF : SD_EVENT_ON);
    }
}

static int on_readable(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_serial *self = ctx;
    (void)source;
    /* One chunk for each turn of the loop; the rest is still readable in the next one. */
    const ssize_t n = read(fd, self->chunk, sizeof self->chunk);
    const int reason = n < 0 ? errno : 0;
    if (n > 0) {
        const dg_ns now = lx_now();
        self->first = self->ops->received(self, now, self->chunk, (size_t)n);
        self->count = (size_t)n - self->first;
        hand_over_characters(self, now);
        return 0;
    }
    const bool nothing_yet = n < 0 && (reason == EAGAIN || reason == EINTR);
    if (!nothing_yet || (events & (EPOLLHUP | EPOLLERR)) != 0) {
        close_gone_port(self, nothing_yet ? 0 : reason);
    }
    return 0;
}

int lx_serial_watch(struct lx_serial *self)
{
    return sd_event_add_io(self->setup.event, &self->io, self->fd, EPOLLIN, on_readable, self);
}

void lx_serial_close(struct lx_serial *self)
{
    if (self == NULL) {
        return;
    }
    shut_port(self);
    lx_timer_close(&self->reopen);
    free(self);
}

struct lx_serial *lx_serial_make(const struct lx_serial_ops *ops, size_t size,
                                 const struct lx_serial_setup *setup, struct lx_error *error)
{
    struct lx_serial *self = lx_allocate(size, "a serial port", error);
    if (self == NULL) {
        return NULL;
    }
    self->ops = ops;
    self->setup = *setup;
    self->uart = setup->uart;
    self->sends = setup->uart;
    self->fd = -1;
    /* Nobody waits for the timer before the port was there once. */
    if (ops->open(self, error) != 0 ||
        lx_timer_make(&self->reopen, setup->event, try_again, self, error) != 0) {
        lx_serial_close(self);
        return NULL;
    }
    return self;
}

void lx_serial_set(struct lx_serial *self, const struct lx_uart *uart)
{
    self->uart = *uart;
    if (self->ops->apply != NULL) {
        self->ops->apply(self);
    }
}
