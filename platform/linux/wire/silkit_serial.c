/* SPDX-License-Identifier: MIT */
/*
 * An asynchronous line in a SIL Kit simulation: characters are bytes, and right for everybody, as
 * on a plain TCP port.
 *
 *   NETWORK/request --> encoders        a message is characters that come one behind the other
 *   NETWORK/reply   <-- encoders        what was over within a step
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <string.h>
#include <sys/eventfd.h>

#include "serial.h"
#include "silkit.h"

struct silkit_serial {
    struct lx_serial serial;
    struct lx_silkit_port request;
    struct lx_silkit_port reply;
    uint8_t sent[LX_SILKIT_CHARACTERS_MAX]; /* since the last step */
    size_t count;
};

static struct silkit_serial *silkit_serial_of(struct lx_serial *serial)
{
    return (struct silkit_serial *)serial;
}

/* --- out --- */

static void flush(void *ctx, dg_ns now)
{
    struct silkit_serial *self = ctx;
    (void)now;
    if (self->count > 0) {
        lx_silkit_publish(&self->reply, self->sent, self->count);
        self->count = 0;
    }
}

/* In real time there are no steps to collect it in. */
static size_t send_characters(struct lx_serial *serial, const uint8_t *bytes, size_t n)
{
    struct silkit_serial *self = silkit_serial_of(serial);
    const size_t room = sizeof self->sent - self->count;
    const size_t sent = n < room ? n : room;
    if (!lx_silkit_is_ready(self->reply.all)) {
        return 0;
    }
    memcpy(self->sent + self->count, bytes, sent);
    self->count += sent;
    if (!lx_silkit_is_virtual(self->reply.all)) {
        flush(self, 0);
    }
    return sent;
}

/* --- in --- */

static void receive(void *ctx, dg_ns now, const struct lx_silkit_message *message, bool last)
{
    struct silkit_serial *self = ctx;
    struct lx_serial *serial = &self->serial;
    const uint8_t *bytes = lx_silkit_bytes(message);
    (void)last;
    for (size_t i = 0; i < message->length; i++) {
        const struct lx_character character = {.byte = bytes[i]};
        serial->baud = LX_BAUD_ANY;
        serial->parity = 0;
        serial->more = message->length - i - 1u;
        serial->setup.rx(serial->setup.ctx, now, &character);
    }
}

/* --- the operations --- */

static int open_serial_topics(struct silkit_serial *self, struct lx_error *error)
{
    const struct lx_serial_setup *setup = &self->serial.setup;
    struct lx_silkit_where where;
    if (lx_silkit_join(setup->silkit, setup->where, &where, error) != 0) {
        return -1;
    }
    self->request = (struct lx_silkit_port){
        .length_max = LX_SILKIT_CHARACTERS_MAX, .receive = receive, .ctx = self};
    self->reply = (struct lx_silkit_port){.step = flush, .ctx = self};
    lx_silkit_name_topic(&self->request, where.network, "request");
    lx_silkit_name_topic(&self->reply, where.network, "reply");
    (void)snprintf(self->serial.address, sizeof self->serial.address, "%s", where.ready);
    return lx_silkit_subscribe(setup->silkit, &self->request, LX_SILKIT_CHARACTERS, error) != 0
               ? -1
               : lx_silkit_offer(setup->silkit, &self->reply, LX_SILKIT_CHARACTERS, error);
}

/* There is no descriptor that could be read; it stands for a line that is there. */
static int open_line(struct lx_serial *serial, struct lx_error *error)
{
    serial->fd = eventfd(0, EFD_CLOEXEC);
    return serial->fd < 0 ? lx_fail(error, "no descriptor is left")
                          : open_serial_topics(silkit_serial_of(serial), error);
}

static const struct lx_serial_ops silkit_ops = {
    .again = "",
    .open = open_line,
    .send = send_characters,
};

struct lx_serial *lx_silkit_serial_open(const struct lx_serial_setup *setup, struct lx_error *error)
{
    return lx_serial_make(&silkit_ops, sizeof(struct silkit_serial), setup, error);
}
