/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CAN bus on the event loop: frames in, frames out. SocketCAN (can_socket.c), an SLCAN adapter on
 * a pseudo-terminal (slcan_pty.c), two that have TCP clients (can_net.c): SLCAN adapters
 * (slcan_net.c), a socketcand (socketcand_net.c); and a bus of a SIL Kit simulation (silkit_can.c).
 *
 * What does not fit the wire at once waits in a queue that keeps the order. As long as it does, no
 * frames come in and the encoders' deadlines wait: whoever is busy sending is deaf to more work.
 *
 * A wire that keeps the pace lets each frame take the time it has at the wire's bit rate. What
 * waits only for that makes nobody deaf before there is more than LX_CAN_PACED_MAX of it.
 */
#ifndef DREHGEBER_LINUX_CAN_H
#define DREHGEBER_LINUX_CAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "drehgeber/canopen.h"
#include "say.h"
#include "timer.h"

/** Longest address of a bus: a path. */
#define LX_CAN_ADDRESS_MAX 4096u
/** Frames that wait for their time before the encoders have to wait, too: until half of them are
 * gone. Nothing is lost; what one moment makes all encoders send may exceed it. */
#define LX_CAN_PACED_MAX 32u

struct lx_can;
struct lx_silkit;

/** A frame with an identifier of 11 or 29 bits. */
struct lx_can_wide {
    bool extended;
    uint32_t id;
    struct dg_can_frame frame; /**< its `id` counts when it is not extended */
};

/** What a kind of bus does in its own way. Nothing here blocks. */
struct lx_can_ops {
    /** Put a frame on the wire, or give it up for good. @return false when there is no room now.
     * A kind that could send a part only takes the frame and calls lx_can_stall(). */
    bool (*write)(struct lx_can *self, const struct dg_can_frame *frame);
    /** Send what write() took but could not send whole. @return false when something is left.
     * NULL: there is never anything left. */
    bool (*flush)(struct lx_can *self);
    /** All that one moment has made the encoders send was given to write(): what that has put
     * together is to go out. NULL: nothing is. */
    void (*push)(struct lx_can *self);
    /** Stop reading, or go on. */
    void (*pause)(struct lx_can *self, bool paused);
    /** Who listens to what may have changed; `net` NULL: everything is wanted. As an operation
     * NULL: everything comes in anyway. */
    void (*filter)(struct lx_can *self, const struct dg_co_net *net);
    /** An encoder's bit rate is `kbaud` now; tell the user when that does not fit the wire. */
    void (*expect)(struct lx_can *self, uint16_t kbaud);
    /** Whether an encoder at `kbaud` understands the wire. NULL: always. */
    bool (*hears)(const struct lx_can *self, uint16_t kbaud);
    /** The wire's own bit rate in bit/s; 0: it has none, or that is not known. NULL: it has none.
     */
    uint32_t (*bit_rate)(const struct lx_can *self);
    /** Bits on the wire so far (can_load.h), of everybody's frames. NULL: those that are sent and
     * received here are all there are. */
    uint64_t (*bits)(const struct lx_can *self);
    /** Whether the wire is there; one that is not is looked for, and what is sent is lost. */
    bool (*up)(const struct lx_can *self);
    /** Close files, remove links. */
    void (*close)(struct lx_can *self);
};

/** What a bus is made of. Everything pointed to must outlive it. */
struct lx_can_setup {
    sd_event *event;
    struct lx_silkit *silkit; /**< the rig in a simulation, for a bus of one */
    const struct lx_say *say;
    const char *where; /**< interface or link; NULL: a link is not wanted */
    /** A frame came in at `now`, which may lie in the past and never decreases. */
    void (*rx)(void *ctx, dg_ns now, const struct dg_can_frame *frame);
    /** The controller says something; `now` as above. */
    void (*bus)(void *ctx, dg_ns now, enum dg_co_bus_event event);
    /** After the last of several frames, after the queue has drained, after the wire's bit rate has
     * changed: look at deadlines and filters. */
    void (*settle)(void *ctx, dg_ns now);
    void *ctx;
};

/** Things nobody has to act on; they only count up. */
struct lx_can_counters {
    uint64_t stalls; /**< times the encoders had to wait for the wire */
    uint64_t lost;   /**< frames that nobody could take: no interface, no master */
};

/** Whether there is anybody else on the wire. */
enum lx_can_company {
    LX_CAN_SOMEBODY,
    LX_CAN_UNKNOWN, /**< nothing has been heard so far */
    LX_CAN_NOBODY,  /**< nobody acknowledges */
};

/** The part that all kinds share; first member of each kind. */
struct lx_can {
    const struct lx_can_ops *ops;
    struct lx_can_setup setup;
    struct lx_timer retry;
    dg_ns delay;      /**< until the next attempt to send */
    bool stalled;     /**< the wire has no room, or too much waits for its time */
    uint32_t pace;    /**< bit/s that frames are spaced by; 0: they are not */
    dg_ns busy_until; /**< the frame that was sent last is on the wire until then */
    uint64_t bits;    /**< sent and received so far, as can_load.h counts them */
    struct dg_can_frame *queue;
    size_t first; /**< oldest frame in queue */
    size_t count;
    size_t capacity;
    struct lx_can_counters counters;
    enum lx_can_company company;
    uint16_t expected;                /**< the encoders' bit rate, in kBd, where that matters */
    const char *kind;                 /**< "can" or "slcan" */
    char address[LX_CAN_ADDRESS_MAX]; /**< interface, or what a master opens */
};

/** Opens one kind of bus. @return NULL with one line in `error` */
typedef struct lx_can *lx_can_open(const struct lx_can_setup *setup, struct lx_error *error);
lx_can_open lx_can_socket_open, lx_slcan_pty_open, lx_slcan_net_open, lx_socketcand_open,
    lx_silkit_can_open;

/** Whether `where` is an address of a kind that has TCP clients. @return 0, or -1 with `error` */
int lx_slcan_net_check(const char *where, struct lx_error *error);
int lx_socketcand_check(const char *where, struct lx_error *error);

/** Whether the kernel has CAN at all. */
bool lx_can_in_kernel(void);

/** Close any of them; NULL is fine. */
void lx_can_close(struct lx_can *self);

/** A frame of somebody else, with so many bits, has been on the wire until now. On one that keeps
 * the pace, what is sent here meanwhile is through later. */
void lx_can_count(struct lx_can *self, uint32_t bits);

/** Bits on the wire so far, in both directions. */
uint64_t lx_can_bits(const struct lx_can *self);

/** Send a frame. Keeps the order, does not block, does not call back. */
void lx_can_send(struct lx_can *self, const struct dg_can_frame *frame);

/** Forget what waits to be sent. */
void lx_can_discard(struct lx_can *self);

/** For the kinds: fill the shared part. @return 0, or -1 with `error` */
int lx_can_init(struct lx_can *self, const struct lx_can_ops *ops, const struct lx_can_setup *setup,
                struct lx_error *error);

/** For the kinds: the wire has no room; it is tried again soon. */
void lx_can_stall(struct lx_can *self);

/** What the kernel says about an interface. */
struct lx_can_link {
    bool up;
    bool is_virtual;  /**< vcan: bit rates mean nothing */
    uint32_t bitrate; /**< bit/s; 0: the kernel does not know it */
    uint64_t frames;  /**< on the wire so far, in both directions, and their data */
    uint64_t bytes;
};

/** Ask about interface `index`. @return 0 or a negative errno */
int lx_can_link_read(unsigned index, struct lx_can_link *link);

#endif
