/* SPDX-License-Identifier: MIT */
/*
 *   client -- on_event --> chunk -- hand_over --> setup.byte() --> the wire
 *   client <-- send_output <-- output <-- lx_peer_put(), lx_peer_answer() --/
 *
 * A client that does not read has no room in `output` after a while: then what others say is lost
 * to it, and what it says waits until there is room for an answer again.
 */
#define _GNU_SOURCE
#include "peers.h"

#include <ctype.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "drehgeber/api.h"

#define OPEN_WORD ",open"
/* What a client that is sent away may still send, and for how long. */
#define FAREWELL_BYTES 65536u
#define FAREWELL DG_S(2)

/* --- the address --- */

static bool is_single_word(const char *text)
{
    const size_t n = strlen(text);
    for (size_t i = 0; i < n; i++) {
        if (isalnum((unsigned char)text[i]) == 0 && strchr("_-.", text[i]) == NULL) {
            return false;
        }
    }
    return n > 0 && n < LX_PEERS_WORD_MAX;
}

bool lx_peers_split(const char *text, struct lx_peers_where *out)
{
    char rest[LX_PEERS_ADDRESS_MAX];
    const size_t n = strlen(text);
    const size_t open = strlen(OPEN_WORD);
    *out = (struct lx_peers_where){.open = n > open && strcmp(text + n - open, OPEN_WORD) == 0};
    const int length = (int)(out->open ? n - open : n);
    if (n >= sizeof rest) {
        return false;
    }
    (void)snprintf(rest, sizeof rest, "%.*s", length, text);
    char *word = strchr(rest, ',');
    if (word != NULL) {
        *word++ = '\0';
        if (!is_single_word(word)) {
            return false;
        }
        (void)snprintf(out->word, sizeof out->word, "%s", word);
    }
    return lx_host_port_split(rest, &out->at);
}

int lx_peers_read(const struct lx_peers_form *form, const char *text, struct lx_peers_where *out,
                  struct lx_error *error)
{
    const size_t n = strlen(form->prefix);
    return strncmp(text, form->prefix, n) == 0 && lx_peers_split(text + n, out) &&
                   (form->named || out->word[0] == '\0')
               ? 0
               : lx_refuse(error, form->right, "%s", "");
}

int lx_peers_check(const struct lx_peers_form *form, const char *text, struct lx_error *error)
{
    struct lx_peers_where ignored;
    return lx_peers_read(form, text, &ignored, error);
}

/* --- clients that come and go --- */

static void free_peer(struct lx_peer *peer)
{
    peer->io = sd_event_source_disable_unref(peer->io);
    (void)close(peer->fd);
    free(peer);
}

static void drop_peer(struct lx_peer *peer)
{
    struct lx_peers *self = peer->all;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        if (self->peer[i] == peer) {
            self->peer[i] = NULL;
        }
    }
    if (self->setup.gone != NULL) {
        self->setup.gone(self->setup.ctx, peer);
    }
    free_peer(peer);
}

static void await_leavers(struct lx_peers *self)
{
    dg_ns first = DG_NEVER;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        first = self->peer[i] == NULL ? first : dg_earliest(first, self->peer[i]->end);
    }
    lx_timer_at(&self->farewell, first);
}

static void on_farewell(void *ctx, dg_ns now)
{
    struct lx_peers *self = ctx;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        if (self->peer[i] != NULL && self->peer[i]->end <= now) {
            drop_peer(self->peer[i]);
        }
    }
    await_leavers(self);
}

/* --- bytes --- */

/* Who is held is listened to without: it may be about to say that it wants to go on. */
static bool has_answer_room(const struct lx_peer *peer)
{
    return peer->held || peer->output_count + LX_PEERS_ANSWER_MAX <= sizeof peer->output;
}

/* Read while what comes in can be handed over; write while there is something to write, or while
 * something that was read waits for room that others may have made by a flush. */
static void watch_peer(struct lx_peer *peer)
{
    const bool takes = !peer->all->paused && has_answer_room(peer);
    const bool reads = peer->away || (takes && peer->count == 0 && peer->end == DG_NEVER);
    const bool writes = (peer->output_count > 0 && !peer->held) || (takes && peer->count > 0);
    const uint32_t events = (reads ? (uint32_t)EPOLLIN : 0u) | (writes ? (uint32_t)EPOLLOUT : 0u);
    (void)sd_event_source_set_io_events(peer->io, events);
}

/* A connection that is broken is told by the loop. */
static void send_peer_output(struct lx_peer *peer)
{
    size_t done = 0;
    while (done < peer->output_count && !peer->held) {
        const ssize_t n = send(peer->fd, peer->output + done, peer->output_count - done,
                               MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            break;
        }
        done += (size_t)n;
    }
    peer->output_count -= done;
    memmove(peer->output, peer->output + done, peer->output_count);
    watch_peer(peer);
}

void lx_peers_flush(struct lx_peers *self)
{
    for (size_t i = 0; i < LX_PEERS_MAX && !self->taking; i++) {
        if (self->peer[i] != NULL && self->peer[i]->output_count > 0) {
            send_peer_output(self->peer[i]);
        }
    }
}

static bool queue_output(struct lx_peer *self, const void *bytes, size_t n, size_t most)
{
    if (self->output_count + n > most) {
        return false;
    }
    memcpy(self->output + self->output_count, bytes, n);
    self->output_count += n;
    return true;
}

bool lx_peer_put(struct lx_peer *self, const void *bytes, size_t n)
{
    return queue_output(self, bytes, n, sizeof self->output - LX_PEERS_ANSWERS);
}

void lx_peer_answer(struct lx_peer *self, const void *bytes, size_t n)
{
    (void)queue_output(self, bytes, n, sizeof self->output);
}

/* Until somebody pauses in the middle, or the client would have to read first. */
static void hand_over_input(struct lx_peer *peer, dg_ns now)
{
    struct lx_peers *self = peer->all;
    const bool inside = self->taking;
    self->taking = true;
    while (peer->count > 0 && !self->paused && has_answer_room(peer) && !peer->away &&
           !peer->broken) {
        const uint8_t byte = peer->chunk[peer->first++];
        peer->count--;
        self->setup.byte(self->setup.ctx, peer, now, byte, peer->count);
    }
    self->taking = inside;
}

void lx_peers_pause(struct lx_peers *self, bool paused)
{
    self->paused = paused;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        if (self->peer[i] != NULL) {
            hand_over_input(self->peer[i], lx_now());
            watch_peer(self->peer[i]);
        }
    }
    lx_peers_flush(self);
}

void lx_peer_send_away(struct lx_peer *self)
{
    self->broken = shutdown(self->fd, SHUT_WR) != 0;
    self->away = true;
    self->count = 0;
    self->heard = 0;
    self->end = dg_after(lx_now(), FAREWELL);
    await_leavers(self->all);
}

/* @return false: it begins as a browser does, and nothing of it is for the wire */
static bool is_welcome(struct lx_peer *peer)
{
    for (size_t i = 0; i < peer->count && peer->begun < sizeof peer->beginning; i++) {
        peer->beginning[peer->begun++] = peer->chunk[i];
    }
    return peer->all->setup.strangers || !lx_begins_foreign(peer->beginning, peer->begun);
}

/* One that was sent away. @return false: it has gone, and `peer` with it */
static bool discard_input(struct lx_peer *peer, ssize_t n)
{
    peer->count = 0;
    peer->unheard += n > 0 ? (size_t)n : 0u;
    if (n > 0 && peer->unheard <= FAREWELL_BYTES) {
        return true;
    }
    drop_peer(peer);
    return false;
}

/* @return false: it has gone, and `peer` with it */
static bool receive_bytes(struct lx_peer *peer)
{
    const ssize_t n = recv(peer->fd, peer->chunk, sizeof peer->chunk, MSG_DONTWAIT);
    const dg_ns now = lx_now();
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return true;
    }
    if (peer->away) {
        return discard_input(peer, n);
    }
    peer->first = 0;
    peer->count = n > 0 ? (size_t)n : 0;
    if (n < 0 || !is_welcome(peer) || (n == 0 && peer->all->setup.linger == 0)) {
        drop_peer(peer);
        return false;
    }
    if (n == 0) {
        peer->heard = 0; /* whoever needs a place takes this one first */
        peer->end = dg_after(now, peer->all->setup.linger);
        await_leavers(peer->all);
    } else {
        peer->heard = now;
    }
    return true;
}

static int on_event(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_peer *peer = ctx;
    struct lx_peers *self = peer->all;
    (void)source;
    (void)fd;
    if ((events & (uint32_t)(EPOLLHUP | EPOLLERR)) != 0) {
        drop_peer(peer);
        return 0;
    }
    if ((events & (uint32_t)EPOLLOUT) != 0) {
        send_peer_output(peer);
    }
    if ((events & (uint32_t)EPOLLIN) != 0 && (peer->count == 0 || peer->away) &&
        !receive_bytes(peer)) {
        return 0;
    }
    hand_over_input(peer, lx_now());
    if (peer->broken) {
        drop_peer(peer);
        return 0;
    }
    watch_peer(peer);
    lx_peers_flush(self);
    return 0;
}

/* A free place, or that of the client which was silent for longest. */
static size_t find_peer_place(struct lx_peers *self)
{
    size_t oldest = 0;
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        if (self->peer[i] == NULL) {
            return i;
        }
        oldest = self->peer[i]->heard < self->peer[oldest]->heard ? i : oldest;
    }
    drop_peer(self->peer[oldest]);
    return oldest;
}

static int on_connection(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_peers *self = ctx;
    const int on = 1;
    (void)source;
    (void)events;
    const int socket = accept4(fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
        return 0; /* it has gone again, or there is no descriptor for it */
    }
    struct lx_peer *peer = calloc(1, sizeof *peer + self->setup.own_size);
    if (peer == NULL) {
        (void)close(socket);
        return 0;
    }
    peer->all = self;
    peer->fd = socket;
    peer->heard = lx_now();
    peer->end = DG_NEVER;
    if (sd_event_add_io(self->setup.event, &peer->io, socket, EPOLLIN, on_event, peer) < 0) {
        free_peer(peer);
        return 0;
    }
    (void)setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    (void)setsockopt(socket, SOL_SOCKET, SO_OOBINLINE, &on,
                     sizeof on); /* telnet's IAC DM is urgent */
    lx_endpoint_keep_alive(socket);
    self->peer[find_peer_place(self)] = peer;
    if (self->setup.came != NULL) {
        self->setup.came(self->setup.ctx, peer);
    }
    watch_peer(peer);
    lx_peers_flush(self);
    return 0;
}

/* --- all of them --- */

static int refuse_peers(const struct lx_peers_where *where, int reason, struct lx_error *error)
{
    char at[LX_PEERS_ADDRESS_MAX];
    struct lx_words right = {""};
    lx_host_port_print(&where->at, at, sizeof at);
    lx_words_add(&right, "use %s%s%s,open if you want that", at, where->word[0] == '\0' ? "" : ",",
                 where->word);
    return reason == EPERM
               ? lx_refuse(error, right.text, "beyond loopback, where anybody could connect")
               : lx_refuse(error, lx_port_right(reason), "cannot listen there: %s",
                           strerror(reason));
}

static void tell_address(struct lx_peers *self)
{
    struct lx_host_port at = self->setup.where->at;
    const char *word = self->setup.where->word;
    lx_host_port_real(&at, self->listener);
    lx_host_port_print(&at, self->address, sizeof self->address);
    const size_t n = strlen(self->address);
    (void)snprintf(self->address + n, sizeof self->address - n, "%s%s", word[0] == '\0' ? "" : ",",
                   word);
    if (!lx_endpoint_is_loopback(self->listener)) {
        lx_note(self->setup.say, "%s:%s: beyond loopback; every machine that reaches it %s",
                self->setup.name, self->address,
                self->setup.beyond != NULL ? self->setup.beyond : "is on this wire");
    }
}

int lx_peers_open(struct lx_peers *self, const struct lx_peers_setup *setup, struct lx_error *error)
{
    *self = (struct lx_peers){.setup = *setup, .listener = -1};
    if (lx_timer_make(&self->farewell, setup->event, on_farewell, self, error) != 0) {
        return -1;
    }
    const struct lx_peers_where *where = setup->where;
    self->listener =
        lx_tcp_listen(&where->at, where->open ? LX_ENDPOINT_ANY : LX_ENDPOINT_LOOPBACK);
    if (self->listener < 0) {
        return refuse_peers(where, errno, error);
    }
    const int result =
        lx_endpoint_watch(self->listener, setup->event, &self->io, on_connection, self);
    if (result < 0) {
        return lx_fail(error, "no event loop: %s", strerror(-result));
    }
    tell_address(self);
    return 0;
}

void lx_peers_close(struct lx_peers *self)
{
    for (size_t i = 0; i < LX_PEERS_MAX; i++) {
        if (self->peer[i] != NULL) {
            free_peer(self->peer[i]);
            self->peer[i] = NULL;
        }
    }
    self->io = sd_event_source_disable_unref(self->io);
    lx_timer_close(&self->farewell);
    if (self->listener >= 0) {
        (void)close(self->listener);
    }
    self->listener = -1;
}
