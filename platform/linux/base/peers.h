/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The TCP clients of a wire: a port with a place for each of them, bytes in, bytes out. One whose
 * machine is gone, one that does not read, one that speaks HTTP: none of them holds up the others.
 */
#ifndef DREHGEBER_LINUX_PEERS_H
#define DREHGEBER_LINUX_PEERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "access.h"
#include "endpoint.h"
#include "say.h"
#include "timer.h"

/** Clients at once; another one takes the place of the one that was silent for longest. */
#define LX_PEERS_MAX 32u
/** Longest HOST:PORT,WORD with its zero. */
#define LX_PEERS_ADDRESS_MAX 300u
/** Longest word, with its zero. */
#define LX_PEERS_WORD_MAX 16u
/** Bytes read at once; a flood is taken in pieces of this. */
#define LX_PEERS_CHUNK 1024u
/** Bytes that wait for a client that does not read ... */
#define LX_PEERS_OUTPUT_MAX 16384u
/** ... of which so many are kept for answers to it, ... */
#define LX_PEERS_ANSWERS 4096u
/** ... the longest of which is this; with less room than that nothing is taken from it. */
#define LX_PEERS_ANSWER_MAX 256u

/** Where the clients of a wire come in: HOST:PORT[,WORD][,open]. */
struct lx_peers_where {
    struct lx_host_port at;
    bool open;                    /**< beyond loopback, too */
    char word[LX_PEERS_WORD_MAX]; /**< letters, digits, '_', '-', '.'; "": none */
};

/** Take an address apart. @return false: it is none */
bool lx_peers_split(const char *text, struct lx_peers_where *out);

/** What the address of a kind of wire looks like. */
struct lx_peers_form {
    const char *prefix; /**< before HOST:PORT; "": none */
    const char *right;  /**< what is told of another one */
    bool named;         /**< there may be a word */
};

/** Take such an address apart. @return 0, or -1 with `error` */
int lx_peers_read(const struct lx_peers_form *form, const char *text, struct lx_peers_where *out,
                  struct lx_error *error);

/** Whether it is one; likewise. */
int lx_peers_check(const struct lx_peers_form *form, const char *text, struct lx_error *error);

struct lx_peers;

/** A client. */
struct lx_peer {
    struct lx_peers *all;
    int fd;
    sd_event_source *io;
    dg_ns heard; /**< when it said something last */
    dg_ns end;   /**< it has ended sending: gone then; DG_NEVER: it has not */
    bool held;   /**< it wants nothing now: what is for it waits. To be set inside setup.byte() */
    bool broken; /**< it takes nothing any more, and goes; likewise */
    bool away;   /**< it was sent away: what it still sends is forgotten, */
    size_t unheard; /**< ... so much so far */
    size_t begun;   /**< of `beginning` */
    size_t first;   /**< of `chunk`: read, and not yet handed to setup.byte() */
    size_t count;
    size_t output_count;
    uint8_t beginning[LX_FOREIGN_MAX]; /**< of what it has sent */
    uint8_t chunk[LX_PEERS_CHUNK];
    uint8_t output[LX_PEERS_OUTPUT_MAX];
    max_align_t own[]; /**< setup.own_size bytes, zero at first */
};

/** What they are made of. Everything pointed to must outlive them. */
struct lx_peers_setup {
    sd_event *event;
    const struct lx_say *say;
    const char *name;   /**< of the wire, for messages: "slcan:tcp" */
    const char *beyond; /**< what whoever reaches it beyond loopback does; NULL: is on this wire */
    bool strangers;     /**< setup.byte() is told also what begins as HTTP or TLS do */
    const struct lx_peers_where *where;
    size_t own_size;
    dg_ns linger; /**< how long one that has ended sending still hears; 0: it goes at once */
    /** One is there. NULL: nobody to tell. */
    void (*came)(void *ctx, struct lx_peer *peer);
    /** A byte of it came in at `now`; `more` that came in with it follow. */
    void (*byte)(void *ctx, struct lx_peer *peer, dg_ns now, uint8_t byte, size_t more);
    /** One has gone, is no longer among them, and is freed after this. NULL: nobody to tell. */
    void (*gone)(void *ctx, struct lx_peer *peer);
    void *ctx;
};

/** All of them. Not to be moved; all zero but for the listener, -1, has nothing to close. */
struct lx_peers {
    struct lx_peers_setup setup;
    int listener; /**< -1: closed */
    sd_event_source *io;
    struct lx_timer farewell;
    bool paused;
    bool taking; /**< setup.byte() runs: what is put meanwhile goes out in one piece */
    struct lx_peer *peer[LX_PEERS_MAX]; /**< owned; NULL: a free place */
    char address[LX_PEERS_ADDRESS_MAX]; /**< HOST:PORT[,WORD], the port as the kernel chose it */
};

/** Listen. @return 0, or -1 with `error`, then close */
int lx_peers_open(struct lx_peers *self, const struct lx_peers_setup *setup,
                  struct lx_error *error);

/** Close all connections, without telling; also after a failed open. */
void lx_peers_close(struct lx_peers *self);

/** Hand over no bytes, also none of those that have been read, or go on. */
void lx_peers_pause(struct lx_peers *self, bool paused);

/** Something for a client, whole or not at all. It goes out with the next flush.
 * @return false: the client has not read what was sent before, and there is no room */
bool lx_peer_put(struct lx_peer *self, const void *bytes, size_t n);

/** An answer to what it has sent, at most LX_PEERS_ANSWER_MAX bytes. From inside setup.came() and
 * setup.byte() there is room for one always, except for a client that is held: it is listened to
 * without, since it may say that it wants to go on, and the answer is lost. */
void lx_peer_answer(struct lx_peer *self, const void *bytes, size_t n);

/** From inside setup.byte(): the client has all its answers, and hears that there are no more. What
 * it still sends is read and forgotten until it has understood, as closing a connection with bytes
 * that nobody has read would lose answers on their way. Whoever needs a place takes this one first.
 */
void lx_peer_send_away(struct lx_peer *self);

/** Send what was put; inside setup.byte() that waits until the last byte. */
void lx_peers_flush(struct lx_peers *self);

#endif
