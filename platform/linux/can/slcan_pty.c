/* SPDX-License-Identifier: MIT */
/*
 * An SLCAN adapter on a pseudo-terminal, with the encoders on its CAN bus:
 *
 *   pty -- on_character --> slcan.c --frame--> encoders
 *                              \--reply--> output --> pty <-- write_frame
 *
 * A master that does not read stalls the bus. When no master has the port open, what is sent is
 * lost, as behind a serial port that nobody has open; the adapter's channel stays as it is. A pty
 * that was gone and is back is an adapter that was plugged in right now.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/inotify.h>
#include <termios.h>
#include <unistd.h>

#include "can.h"
#include "can_load.h"
#include "drehgeber/slcan.h"
#include "serial.h"

/* A line that the pty has taken a part of, with a zero behind it; a reply is shorter. */
#define OUTPUT_MAX (DG_SLCAN_TEXT_MAX + 1u)
/* A pty has no speed; this is what masters set. */
#define BAUD 115200u

struct slcan_pty {
    struct lx_can can;
    struct lx_serial *serial;
    struct dg_slcan codec;
    int slave; /* held open: to drop what a master has not read */
    int openings;
    sd_event_source *openings_io;
    int masters;       /* descriptors of others on the port */
    uint16_t expected; /* the encoders' bit rate, in kBd */
    bool mismatch;     /* the channel has another one, and the user has been told */
    uint8_t output[OUTPUT_MAX];
    size_t output_count;
};

static struct slcan_pty *pty_of(struct lx_can *can)
{
    return (struct slcan_pty *)can;
}

/* --- out --- */

static bool anybody_reads(const struct slcan_pty *self)
{
    return self->masters > 0 && lx_serial_up(self->serial);
}

/* Send what there is. @return whether all of it is gone */
static bool flush(struct lx_can *can)
{
    struct slcan_pty *self = pty_of(can);
    const size_t n = self->output_count;
    const size_t done = anybody_reads(self) ? lx_serial_send(self->serial, self->output, n) : n;
    self->output_count -= done;
    memmove(self->output, self->output + done, self->output_count);
    return self->output_count == 0;
}

/* Send now, the rest later: the bus is stalled until it is gone, and meanwhile nothing is put. */
static void send_output(struct slcan_pty *self)
{
    if (!flush(&self->can)) {
        lx_can_stall(&self->can);
    }
}

static bool write_frame(struct lx_can *can, const struct dg_can_frame *frame)
{
    struct slcan_pty *self = pty_of(can);
    if (!flush(can)) {
        return false;
    }
    if (self->codec.state == DG_SLCAN_CLOSED || !anybody_reads(self)) {
        can->counters.lost++;
        return true;
    }
    self->output_count =
        dg_slcan_print(&self->codec, frame, lx_now() / DG_MS(1), (char *)self->output);
    send_output(self);
    return true;
}

/* --- bit rates --- */

static bool hears(const struct lx_can *can, uint16_t kbaud)
{
    const struct dg_slcan *codec = &((const struct slcan_pty *)can)->codec;
    return codec->state != DG_SLCAN_CLOSED && (codec->kbaud == 0 || codec->kbaud == kbaud);
}

static uint32_t bit_rate(const struct lx_can *can)
{
    return 1000u * ((const struct slcan_pty *)can)->codec.kbaud;
}

/* Once per episode, which rate would be right. */
static void check_rate(struct slcan_pty *self)
{
    if (self->codec.state == DG_SLCAN_CLOSED) {
        return;
    }
    const bool differs = !hears(&self->can, self->expected);
    if (differs && !self->mismatch) {
        lx_note(self->can.setup.say,
                "the master has opened the channel at %u kBd, the encoder expects %u kBd",
                self->codec.kbaud, self->expected);
    }
    self->mismatch = differs;
}

static void expect(struct lx_can *can, uint16_t kbaud)
{
    pty_of(can)->expected = kbaud;
    check_rate(pty_of(can));
}

/* --- in --- */

static void take_line(struct slcan_pty *self, dg_ns now, const struct dg_slcan_event *event,
                      enum dg_slcan_state before)
{
    const struct lx_can_setup *setup = &self->can.setup;
    self->output_count = strlen(event->reply);
    memcpy(self->output, event->reply, self->output_count);
    send_output(self);
    if (event->has_frame) {
        setup->rx(setup->ctx, now, &event->frame);
        setup->settle(setup->ctx, now);
    } else if (event->extended) {
        lx_can_count(&self->can, LX_CAN_EXTENDED_BITS(1u, lx_can_bytes(&event->frame)));
    } else if (self->codec.state != before) {
        check_rate(self);
        setup->settle(setup->ctx, now);
    }
}

/* Line by line: one whose answer does not fit the pty stalls the bus, and that pauses the port. */
static void on_character(void *ctx, dg_ns now, const struct lx_character *character)
{
    struct slcan_pty *self = ctx;
    struct dg_slcan_event event;
    const enum dg_slcan_state before = self->codec.state;
    if (dg_slcan_feed(&self->codec, character->byte, &event)) {
        take_line(self, now, &event, before);
    }
}

static void pause_reading(struct lx_can *can, bool paused)
{
    lx_serial_pause(pty_of(can)->serial, paused);
}

/* --- who has the port open --- */

/* Nobody any more: what they have not read is not for the next one. */
static void forget(struct slcan_pty *self)
{
    dg_slcan_resync(&self->codec);
    lx_can_discard(&self->can);
    self->output_count = 0;
    (void)tcflush(self->slave, TCIFLUSH);
}

static int on_opening(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct slcan_pty *self = ctx;
    struct inotify_event event; /* of a file: no name behind it */
    (void)source;
    (void)events;
    while (read(fd, &event, sizeof event) == (ssize_t)sizeof event) {
        if ((event.mask & (uint32_t)IN_OPEN) != 0) {
            self->masters++;
        } else if ((event.mask & (uint32_t)IN_CLOSE) != 0 && --self->masters == 0) {
            forget(self);
        }
    }
    return 0;
}

static int watch_openings(struct slcan_pty *self)
{
    const char *path = self->serial->address;
    self->slave = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
    self->openings = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    if (self->slave < 0 || self->openings < 0 ||
        inotify_add_watch(self->openings, path, (uint32_t)IN_OPEN | (uint32_t)IN_CLOSE) < 0) {
        return -errno;
    }
    const int result = sd_event_add_io(self->can.setup.event, &self->openings_io, self->openings,
                                       EPOLLIN, on_opening, self);
    /* Before anything else: a master is there before what it writes. */
    return result < 0
               ? result
               : sd_event_source_set_priority(self->openings_io, SD_EVENT_PRIORITY_IMPORTANT - 1);
}

/* --- the port --- */

static void unwatch_openings(struct slcan_pty *self)
{
    self->openings_io = sd_event_source_disable_unref(self->openings_io);
    if (self->openings >= 0) {
        (void)close(self->openings);
    }
    if (self->slave >= 0) {
        (void)close(self->slave);
    }
    self->openings = -1;
    self->slave = -1;
}

static int use_address(struct slcan_pty *self)
{
    (void)snprintf(self->can.address, sizeof self->can.address, "%s", self->serial->address);
    return watch_openings(self);
}

/* Another pty: whoever had the old one open has nothing any more. */
static void back(void *ctx)
{
    struct slcan_pty *self = ctx;
    forget(self);
    unwatch_openings(self);
    self->codec = (struct dg_slcan){.state = DG_SLCAN_CLOSED};
    self->mismatch = false;
    self->masters = 0;
    const int result = use_address(self);
    if (result < 0) {
        lx_complain("%s: cannot watch the pty: %s", self->can.address, strerror(-result));
    }
    pause_reading(&self->can, self->can.stalled);
    self->can.setup.settle(self->can.setup.ctx, lx_now());
}

/* --- the operations --- */

static bool up(const struct lx_can *can)
{
    return lx_serial_up(((const struct slcan_pty *)can)->serial);
}

static void close_slcan(struct lx_can *can)
{
    struct slcan_pty *self = pty_of(can);
    lx_serial_close(self->serial);
    unwatch_openings(self);
}

static const struct lx_can_ops slcan_ops = {
    .write = write_frame,
    .flush = flush,
    .pause = pause_reading,
    .expect = expect,
    .hears = hears,
    .bit_rate = bit_rate,
    .up = up,
    .close = close_slcan,
};

static int start(struct slcan_pty *self, struct lx_error *error)
{
    const struct lx_serial_setup line = {
        .event = self->can.setup.event,
        .say = self->can.setup.say,
        .where = self->can.setup.where,
        .uart = {.baud = BAUD, .parity = 'N'},
        .found_baud = BAUD,
        .any_line = true,
        .rx = on_character,
        .back = back,
        .ctx = self,
    };
    self->serial = lx_pty_open(&line, error);
    if (self->serial == NULL) {
        return -1;
    }
    const int result = use_address(self);
    return result < 0 ? lx_fail(error, "cannot watch the pty: %s", strerror(-result)) : 0;
}

struct lx_can *lx_slcan_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    struct slcan_pty *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for an adapter");
        return NULL;
    }
    self->slave = -1;
    self->openings = -1;
    self->can.kind = "slcan";
    if (lx_can_init(&self->can, &slcan_ops, setup, error) != 0 || start(self, error) != 0) {
        lx_can_close(&self->can);
        return NULL;
    }
    return &self->can;
}
