/* SPDX-License-Identifier: MIT */
/*
 *   client -- dialect.byte() --> answer; frame --> other clients, encoders
 *   encoders -- write_frame --> all clients
 *
 * What a moment makes the encoders send, and what a client's bytes that came in at once do, goes
 * out in one piece to each. A client that does not read loses frames, whole ones; nobody waits for
 * it.
 */
#define _GNU_SOURCE
#include "can_net.h"

#include <stdio.h>
#include <string.h>

static struct lx_can_net *net_of(struct lx_can *can)
{
    return (struct lx_can_net *)can;
}

/* --- who is on the bus --- */

static bool is_open(const struct lx_can_net *self, size_t i)
{
    const struct lx_peer *peer = self->peers.peer[i];
    return peer != NULL && self->dialect->is_open(peer->own);
}

static uint16_t kbaud_of(const struct lx_can_net *self, const struct lx_peer *peer)
{
    return self->dialect->kbaud == NULL ? 0 : self->dialect->kbaud(peer->own);
}

/* In kBd; 0: nobody has one. */
static uint16_t rate(const struct lx_can_net *self)
{
    uint16_t found = 0;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        const uint16_t kbaud = is_open(self, i) ? kbaud_of(self, self->peers.peer[i]) : 0;
        if (found == 0 || kbaud == self->can.expected) {
            found = kbaud == 0 ? found : kbaud;
        }
    }
    return found;
}

static bool fits_rate(uint16_t bus, uint16_t kbaud)
{
    return bus == 0 || kbaud == 0 || bus == kbaud;
}

/* --- out --- */

/* @return how many clients there are that could hear it */
static size_t tell_clients(struct lx_can_net *self, const struct lx_peer *from, dg_ns now,
                           const struct lx_can_wide *frame)
{
    const struct lx_can_dialect *dialect = self->dialect;
    const uint16_t bus = rate(self);
    char text[LX_CAN_TEXT_MAX];
    size_t count = 0;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        struct lx_peer *peer = self->peers.peer[i];
        if (!is_open(self, i) || peer == from || !fits_rate(bus, kbaud_of(self, peer))) {
            continue;
        }
        count++;
        if (dialect->wants == NULL || dialect->wants(peer->own, frame)) {
            const size_t n = dialect->print(peer->own, frame, now, text);
            self->can.counters.lost += lx_peer_put(peer, text, n) ? 0u : 1u;
        }
    }
    return count;
}

static bool write_frame(struct lx_can *can, const struct dg_can_frame *frame)
{
    const struct lx_can_wide wide = {.id = frame->id, .frame = *frame};
    can->counters.lost += tell_clients(net_of(can), NULL, lx_now(), &wide) == 0 ? 1u : 0u;
    return true;
}

static void push(struct lx_can *can)
{
    lx_peers_flush(&net_of(can)->peers);
}

/* --- in --- */

bool lx_can_net_spread(struct lx_can_net *self, const struct lx_peer *from, dg_ns now,
                       const struct lx_can_wide *frame)
{
    if (!fits_rate(rate(self), kbaud_of(self, from))) {
        return false;
    }
    (void)tell_clients(self, from, now, frame);
    return true;
}

static void came(void *ctx, struct lx_peer *peer)
{
    const char *hello = ((const struct lx_can_net *)ctx)->dialect->hello;
    if (hello != NULL) {
        lx_peer_answer(peer, hello, strlen(hello));
    }
}

static void on_byte(void *ctx, struct lx_peer *peer, dg_ns now, uint8_t byte, size_t more)
{
    struct lx_can_net *self = ctx;
    (void)more;
    self->dialect->byte(self, peer, now, byte);
}

/* Whether anybody is left who acknowledges is to be seen. */
static void gone(void *ctx, struct lx_peer *peer)
{
    const struct lx_can_net *self = ctx;
    (void)peer;
    self->can.setup.settle(self->can.setup.ctx, lx_now());
}

/* --- the operations --- */

static void pause_reading(struct lx_can *can, bool paused)
{
    lx_peers_pause(&net_of(can)->peers, paused);
}

static bool anybody_is_open(const struct lx_can *can)
{
    const struct lx_can_net *self = (const struct lx_can_net *)can;
    size_t i = 0;
    while (i < LX_PEERS_MAX && !is_open(self, i)) {
        i++;
    }
    return i < LX_PEERS_MAX;
}

static void expect(struct lx_can *can, uint16_t kbaud)
{
    const struct lx_can_net *self = net_of(can);
    can->expected = kbaud;
    for (size_t i = 0; i < LX_PEERS_MAX && self->dialect->check != NULL; i++) {
        if (self->peers.peer[i] != NULL) {
            self->dialect->check(self->peers.peer[i]->own, can->setup.say, kbaud);
        }
    }
}

static uint32_t bit_rate(const struct lx_can *can)
{
    return 1000u * rate((const struct lx_can_net *)can);
}

static void close_net(struct lx_can *can)
{
    lx_peers_close(&net_of(can)->peers);
}

const struct lx_can_ops lx_can_net_ops = {
    .write = write_frame,
    .push = push,
    .pause = pause_reading,
    .expect = expect,
    .open = anybody_is_open,
    .bit_rate = bit_rate,
    .close = close_net,
};

/* --- opening --- */

int lx_can_net_start(struct lx_can *can, struct lx_error *error)
{
    struct lx_can_net *self = net_of(can);
    const struct lx_can_dialect *dialect = can->kind->dialect;
    const struct lx_peers_setup peers = {
        .event = can->setup.event,
        .say = can->setup.say,
        .name = dialect->kind,
        .where = &self->where,
        .own_size = dialect->own_size,
        .came = came,
        .byte = on_byte,
        .gone = gone,
        .ctx = self,
    };
    self->dialect = dialect;
    self->peers.listener = -1;
    if (lx_peers_read(&dialect->address, can->setup.where, &self->where, error) != 0 ||
        lx_peers_open(&self->peers, &peers, error) != 0) {
        return -1;
    }
    (void)snprintf(can->address, sizeof can->address, "%s%s", dialect->address.prefix,
                   self->peers.address);
    return 0;
}
