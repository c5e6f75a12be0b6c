/* SPDX-License-Identifier: MIT */
/*
 * A serial port that is a TCP port: its clients are on the line, each hears all others and the
 * encoders. Over tcp:HOST:PORT characters are bytes, and right for everybody; over
 * rfc2217:HOST:PORT each client has a UART with a setting, and what it hears at another one is
 * damaged, as it is to the encoders.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <string.h>

#include "drehgeber/rfc2217.h"
#include "peers.h"
#include "serial.h"

/* A client that has sent its last character still hears the answer. */
#define LINGER DG_S(2)

struct net_port {
    struct lx_serial serial;
    struct lx_peers_where where;
    struct lx_peers peers;
    bool telnet;
};

static struct net_port *port_of(struct lx_serial *serial)
{
    return (struct net_port *)serial;
}

/* --- clients hear --- */

static bool tell_peer(const struct net_port *self, struct lx_peer *peer,
                      const struct dg_rfc2217_sound *sound)
{
    const struct dg_rfc2217 *client = (const void *)peer->own;
    uint8_t text[DG_RFC2217_TEXT_MAX];
    if (!self->telnet) {
        return lx_peer_put(peer, &sound->byte, 1);
    }
    return lx_peer_put(peer, text, dg_rfc2217_print(client, sound, text));
}

/* @return how many have heard it */
static size_t tell_all(struct net_port *self, const struct lx_peer *from,
                       const struct dg_rfc2217_sound *sound)
{
    size_t count = 0;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        struct lx_peer *peer = self->peers.peer[i];
        if (peer != NULL && peer != from) {
            const bool heard = tell_peer(self, peer, sound);
            self->serial.counters.lost += heard ? 0u : 1u;
            count++;
        }
    }
    return count;
}

static size_t send_bytes(struct lx_serial *serial, const uint8_t *bytes, size_t n)
{
    struct net_port *self = port_of(serial);
    size_t sent = 0;
    for (size_t i = 0; i < n; i++) {
        const struct dg_rfc2217_sound sound = {
            {serial->sends.baud, serial->sends.parity}, bytes[i], 0};
        sent += tell_all(self, NULL, &sound) > 0 ? 1u : 0u;
    }
    lx_peers_flush(&self->peers);
    return sent;
}

/* --- clients speak --- */

static void take_serial_character(struct net_port *self, const struct lx_peer *from, dg_ns now,
                                  const struct lx_character *character)
{
    struct lx_serial *serial = &self->serial;
    const uint8_t line = character->damaged ? DG_RFC2217_FRAMING | DG_RFC2217_BREAK_SEEN : 0;
    const struct dg_rfc2217_sound sound = {{serial->baud, serial->parity}, character->byte, line};
    (void)tell_all(self, from, &sound);
    serial->setup.rx(serial->setup.ctx, now, character);
}

static void on_byte(void *ctx, struct lx_peer *peer, dg_ns now, uint8_t byte, size_t more)
{
    struct net_port *self = ctx;
    struct lx_serial *serial = &self->serial;
    struct dg_rfc2217 *client = (void *)peer->own;
    struct lx_character character = {.byte = byte};
    struct dg_rfc2217_event event = {.what = DG_RFC2217_CHARACTER, .character = byte};
    serial->more = more;
    serial->baud = LX_BAUD_ANY;
    serial->parity = 0;
    if (self->telnet) {
        const struct dg_rfc2217_uart found = {serial->uart.baud, serial->uart.parity};
        dg_rfc2217_feed(client, &found, byte, &event);
        lx_peer_answer(peer, event.answer, event.length);
        peer->held = client->suspended;
        const struct dg_rfc2217_uart own = dg_rfc2217_setting(client);
        serial->baud = own.baud;
        serial->parity = own.parity;
        character.byte = event.what == DG_RFC2217_BREAK ? 0 : event.character;
        character.damaged = event.what == DG_RFC2217_BREAK;
    }
    if (event.what != DG_RFC2217_NOTHING) {
        take_serial_character(self, peer, now, &character);
    }
}

/* --- the operations --- */

#define RIGHT "expected rfc2217:HOST:PORT or tcp:HOST:PORT, with or without ,open"
static const struct lx_peers_form raw = {"tcp:", RIGHT, false};
static const struct lx_peers_form rfc2217 = {"rfc2217:", RIGHT, false};

static const struct lx_peers_form *form_of(const char *where)
{
    return strncmp(where, rfc2217.prefix, strlen(rfc2217.prefix)) == 0 ? &rfc2217 : &raw;
}

int lx_net_port_check(const char *where, struct lx_error *error)
{
    return lx_peers_check(form_of(where), where, error);
}

static int open_net(struct lx_serial *serial, struct lx_error *error)
{
    struct net_port *self = port_of(serial);
    const struct lx_peers_form *form = form_of(serial->setup.where);
    self->telnet = form == &rfc2217;
    const struct lx_peers_setup peers = {
        .event = serial->setup.event,
        .say = serial->setup.say,
        .name = self->telnet ? "rs485:rfc2217" : "rs485:tcp",
        .where = &self->where,
        .own_size = sizeof(struct dg_rfc2217),
        .linger = LINGER,
        .byte = on_byte,
        .ctx = self,
    };
    self->peers.listener = -1;
    if (lx_peers_read(form, serial->setup.where, &self->where, error) != 0 ||
        lx_peers_open(&self->peers, &peers, error) != 0) {
        return -1;
    }
    serial->fd = self->peers.listener;
    (void)snprintf(serial->address, sizeof serial->address, "%s%s", form->prefix,
                   self->peers.address);
    return 0;
}

static void shut_net(struct lx_serial *serial)
{
    lx_peers_close(&port_of(serial)->peers);
    serial->fd = -1; /* it was theirs */
}

static const struct lx_serial_ops net_ops = {
    .again = "listening there again",
    .open = open_net,
    .send = send_bytes,
    .shut = shut_net,
};

struct lx_serial *lx_net_port_open(const struct lx_serial_setup *setup, struct lx_error *error)
{
    return lx_serial_make(&net_ops, sizeof(struct net_port), setup, error);
}
