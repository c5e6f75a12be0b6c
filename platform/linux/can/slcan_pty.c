/* SPDX-License-Identifier: MIT */
/*
 * An SLCAN adapter on a pseudo-terminal, with the encoders on its CAN bus:
 *
 *   pty -- on_character --> slcan.c --frame--> encoders
 *                              \--reply--> output --> pty
 *                          write_frame -----/
 *
 * What a moment makes the encoders send, and what all the characters that came in at once do, goes
 * out in one piece.
 *
 * A master that does not read stalls the bus. When no master has the port open, what is sent is
 * lost, as behind a serial port that nobody has open; the adapter's channel stays as it is. A pty
 * that was gone and is back is an adapter that was plugged in right now.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/inotify.h>
#include <termios.h>
#include <unistd.h>

#include "serial.h"
#include "slcan_channel.h"

/* Frames that wait for the others of their moment; about as much as a pty takes at once. */
#define FRAMES_MAX 4096u
/* Behind them there is room for a frame and a reply, with a zero behind it: then the bus stalls. */
#define OUTPUT_MAX (FRAMES_MAX + 2u * DG_SLCAN_TEXT_MAX + 1u)
/* A frame of the encoders in a line of its own: they send no other ones. */
#define FRAME 't'
#define END_OF_LINE '\r'
/* A pty has no speed; this is what masters set. */
#define BAUD 115200u

struct slcan_pty {
    struct lx_can can;
    struct lx_serial *serial;
    struct lx_slcan_channel channel;
    int slave; /* held open: to drop what a master has not read */
    sd_event_source *openings;
    int masters; /* descriptors of others on the port */
    bool taking; /* a character, of which more may come of than it has so far */
    uint8_t output[OUTPUT_MAX];
    size_t output_count;
};

static struct slcan_pty *slcan_pty_of(struct lx_can *can)
{
    return (struct slcan_pty *)can;
}

/* --- out --- */

static bool anybody_reads(const struct slcan_pty *self)
{
    return self->masters > 0 && lx_serial_up(self->serial);
}

/* Nobody takes it: whole frames are counted. */
static void drop_output(struct slcan_pty *self)
{
    bool begins = true;
    for (size_t i = 0; i < self->output_count; i++) {
        self->can.counters.lost += begins && self->output[i] == FRAME;
        begins = self->output[i] == END_OF_LINE;
    }
    self->output_count = 0;
}

/* Send what there is. @return whether all of it is gone */
static bool flush(struct lx_can *can)
{
    struct slcan_pty *self = slcan_pty_of(can);
    if (!anybody_reads(self)) {
        drop_output(self);
    } else if (self->output_count > 0) {
        const size_t done = lx_serial_send(self->serial, self->output, self->output_count);
        self->output_count -= done;
        memmove(self->output, self->output + done, self->output_count);
    }
    return self->output_count == 0;
}

/* Send now, the rest later: the bus is stalled until it is gone, and meanwhile nothing is put. */
static void send_pty_output(struct slcan_pty *self)
{
    if (!flush(&self->can)) {
        lx_can_stall(&self->can);
    }
}

static void push(struct lx_can *can)
{
    if (!slcan_pty_of(can)->taking) {
        send_pty_output(slcan_pty_of(can));
    }
}

static bool write_frame(struct lx_can *can, const struct dg_can_frame *frame)
{
    struct slcan_pty *self = slcan_pty_of(can);
    if (self->output_count > FRAMES_MAX && !flush(can)) {
        return false;
    }
    if (self->channel.codec.state == DG_SLCAN_CLOSED || !anybody_reads(self)) {
        can->counters.lost++;
        return true;
    }
    char *to = (char *)self->output + self->output_count;
    self->output_count += dg_slcan_print(&self->channel.codec, frame, lx_now() / DG_MS(1), to);
    return true;
}

/* --- bit rates --- */

static bool is_open(const struct lx_can *can)
{
    return ((const struct slcan_pty *)can)->channel.codec.state != DG_SLCAN_CLOSED;
}

static uint32_t bit_rate(const struct lx_can *can)
{
    return 1000u * ((const struct slcan_pty *)can)->channel.codec.kbaud;
}

static void expect(struct lx_can *can, uint16_t kbaud)
{
    can->expected = kbaud;
    lx_slcan_check(&slcan_pty_of(can)->channel, can->setup.say, kbaud);
}

/* --- in --- */

static void put_reply(struct slcan_pty *self, const char *reply)
{
    const size_t n = strlen(reply);
    if (self->output_count > FRAMES_MAX) {
        send_pty_output(self);
    }
    memcpy(self->output + self->output_count, reply, n);
    self->output_count += n;
}

/* Line by line: one whose answer does not fit the pty stalls the bus, and that pauses the port. */
static void on_character(void *ctx, dg_ns now, const struct lx_character *character)
{
    struct slcan_pty *self = ctx;
    struct dg_slcan_event event;
    struct dg_slcan *codec = &self->channel.codec;
    const enum dg_slcan_state before = codec->state;
    self->taking = true;
    if (dg_slcan_feed(codec, character->byte, &event)) {
        put_reply(self, event.reply);
        lx_slcan_act(&self->channel, &self->can, now, &event, codec->state != before);
    }
    self->taking = false;
    if (self->serial->more == 0) {
        send_pty_output(self);
    }
}

static void pause_reading(struct lx_can *can, bool paused)
{
    lx_serial_pause(slcan_pty_of(can)->serial, paused);
}

/* --- who has the port open --- */

/* Nobody any more: what they have not read is not for the next one. */
static void forget_output(struct slcan_pty *self)
{
    dg_slcan_resync(&self->channel.codec);
    lx_can_discard(&self->can);
    drop_output(self);
    (void)tcflush(self->slave, TCIFLUSH);
}

static int on_opening(sd_event_source *source, const struct inotify_event *event, void *ctx)
{
    struct slcan_pty *self = ctx;
    (void)source;
    if ((event->mask & (uint32_t)IN_OPEN) != 0) {
        self->masters++;
    } else if ((event->mask & (uint32_t)IN_CLOSE) != 0 && --self->masters == 0) {
        forget_output(self);
    }
    return 0;
}

static int watch_openings(struct slcan_pty *self)
{
    const char *path = self->serial->address;
    self->slave = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (self->slave < 0) {
        return -errno;
    }
    /* The loop has one inotify instance for all of a rig, of the few that a user may have. */
    const int result =
        sd_event_add_inotify(self->can.setup.event, &self->openings, path,
                             (uint32_t)IN_OPEN | (uint32_t)IN_CLOSE, on_opening, self);
    /* Before anything else: a master is there before what it writes. */
    return result < 0
               ? result
               : sd_event_source_set_priority(self->openings, SD_EVENT_PRIORITY_IMPORTANT - 1);
}

/* --- the port --- */

static void unwatch_openings(struct slcan_pty *self)
{
    self->openings = sd_event_source_disable_unref(self->openings);
    if (self->slave >= 0) {
        (void)close(self->slave);
    }
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
    forget_output(self);
    unwatch_openings(self);
    self->channel = (struct lx_slcan_channel){.mismatch = false};
    self->masters = 0;
    const int result = use_address(self);
    if (result < 0) {
        lx_complain("%s: cannot watch the pty: %s", self->can.address, strerror(-result));
    }
    pause_reading(&self->can, lx_can_is_paused(&self->can));
    self->can.setup.settle(self->can.setup.ctx, lx_now());
}

/* --- the operations --- */

static bool up(const struct lx_can *can)
{
    return lx_serial_up(((const struct slcan_pty *)can)->serial);
}

static void close_slcan(struct lx_can *can)
{
    struct slcan_pty *self = slcan_pty_of(can);
    lx_serial_close(self->serial);
    unwatch_openings(self);
}

static const struct lx_can_ops slcan_ops = {
    .write = write_frame,
    .flush = flush,
    .push = push,
    .pause = pause_reading,
    .expect = expect,
    .open = is_open,
    .bit_rate = bit_rate,
    .up = up,
    .close = close_slcan,
};

static int start_pty(struct lx_can *can, struct lx_error *error)
{
    struct slcan_pty *self = slcan_pty_of(can);
    const struct lx_serial_setup line = {
        .event = can->setup.event,
        .say = can->setup.say,
        .where = can->setup.where,
        .uart = {.baud = BAUD, .parity = 'N'},
        .found_baud = BAUD,
        .any_line = true,
        .rx = on_character,
        .back = back,
        .ctx = self,
    };
    self->slave = -1;
    self->serial = lx_pty_open(&line, error);
    if (self->serial == NULL) {
        return -1;
    }
    const int result = use_address(self);
    return result < 0 ? lx_refuse(error, lx_more_of(-result), "cannot watch the pty: %s",
                                  strerror(-result))
                      : 0;
}

static const struct lx_can_kind kind = {sizeof(struct slcan_pty), &slcan_ops, start_pty, NULL};

struct lx_can *lx_slcan_pty_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    return lx_can_make(&kind, setup, error);
}
