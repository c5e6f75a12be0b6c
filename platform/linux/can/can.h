/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CAN bus on the event loop: frames in, frames out. SocketCAN (can_socket.c), an SLCAN adapter on
 * a pseudo-terminal (slcan_pty.c), two that have TCP clients (can_net.c): SLCAN adapters
 * (slcan_net.c), a socketcand (socketcand_net.c); and a bus of a SIL Kit simulation (silkit_can.c).
 *
 * What does not fit the wire at once waits in a queue that keeps the order. As long as it does, no
 * frames come in and the encoders' deadlines wait: whoever is busy sending is deaf to more work.
 */
#ifndef DREHGEBER_LINUX_CAN_H
#define DREHGEBER_LINUX_CAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "drehgeber/bus_frames.h"
#include "say.h"
#include "tap.h"
#include "timer.h"

/** Longest address of a bus: a path. */
#define LX_CAN_ADDRESS_MAX 4096u

struct lx_can;
struct lx_can_dialect;
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
    /** Stop reading, or go on. NULL: there is always room, so nobody waits for it. */
    void (*pause)(struct lx_can *self, bool paused);
    /** Who listens to what may have changed (dg_bus_frames_listens()); `bus` NULL: everything is
     * wanted. As an operation NULL: everything comes in anyway. */
    void (*filter)(struct lx_can *self, const struct dg_bus *bus);
    /** An encoder's bit rate is `kbaud` now; tell the user when that does not fit the wire. */
    void (*expect)(struct lx_can *self, uint16_t kbaud);
    /** Whether there is a channel, which encoders of another bit rate do not understand. NULL:
     * there always is one, which all of them do. */
    bool (*open)(const struct lx_can *self);
    /** The wire's own bit rate in bit/s; 0: it has none, or that is not known. NULL: it has none.
     */
    uint32_t (*bit_rate)(const struct lx_can *self);
    /** Bits on the wire so far (DG_CAN_BITS()), of everybody's frames. NULL: those that are sent
     * and received here are all there are. */
    uint64_t (*bits)(const struct lx_can *self);
    /** Whether the wire is there; one that is not is looked for, and what is sent is lost. NULL: it
     * always is. */
    bool (*up)(const struct lx_can *self);
    /** Close files, remove links. */
    void (*close)(struct lx_can *self);
};

/** A kind of bus. */
struct lx_can_kind {
    size_t size; /**< of its struct, which begins with struct lx_can */
    const struct lx_can_ops *ops;
    /** Open files, make links; all of its struct is zero but the shared part.
     * @return 0, or -1 with `error`; then close() cleans up */
    int (*start)(struct lx_can *self, struct lx_error *error);
    const struct lx_can_dialect *dialect; /**< of its TCP clients; NULL: it has none */
};

/** What a bus is made of. Everything pointed to must outlive it. */
struct lx_can_setup {
    sd_event *event;
    struct lx_silkit *silkit; /**< the rig in a simulation, for a bus of one: */
    struct lx_timer *timer;   /**< ... what it waits for, */
    const struct lx_tap *tap; /**< ... and who listens to it */
    const struct lx_say *say;
    const char *where; /**< interface or link; NULL: a link is not wanted */
    /** A frame came in at `now`, which may lie in the past and never decreases. */
    void (*rx)(void *ctx, dg_ns now, const struct dg_can_frame *frame);
    /** A frame that no encoder understands, with so many bits, has been on the wire until now. */
    void (*foreign)(void *ctx, uint32_t bits);
    /** The controller says something, DG_HOST_BUS_ACTIVE to _OVERRUN; `now` as above. */
    void (*bus)(void *ctx, dg_ns now, enum dg_host_bus event);
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

/** The part that all kinds share; first member of each kind. */
struct lx_can {
    const struct lx_can_kind *kind;
    const struct lx_can_ops *ops; /**< the kind's */
    struct lx_can_setup setup;
    struct lx_timer retry;
    dg_ns delay;  /**< until the next attempt to send */
    bool stalled; /**< the wire has no room */
    bool crowded; /**< the encoders wait for something else */
    struct dg_can_frame *queue;
    size_t first; /**< oldest frame in queue */
    size_t count;
    size_t capacity;
    struct lx_can_counters counters;
    enum dg_bus_company company;      /**< somebody, unless the kind says so */
    uint16_t expected;                /**< the encoders' bit rate, in kBd, where that matters */
    char address[LX_CAN_ADDRESS_MAX]; /**< interface, or what a master opens */
};

/** Opens one kind of bus. @return NULL with one line in `error` */
typedef struct lx_can *lx_can_open(const struct lx_can_setup *setup, struct lx_error *error);
lx_can_open lx_can_socket_open, lx_slcan_open, lx_slcan_pty_open, lx_socketcand_open,
    lx_silkit_can_open, lx_silkit_pack_open;

/** Whether `where` is an address of a kind that has TCP clients. @return 0, or -1 with `error` */
int lx_slcan_address_check(const char *where, struct lx_error *error);
int lx_socketcand_check(const char *where, struct lx_error *error);

/** Whether the kernel has CAN at all. */
bool lx_can_in_kernel(void);

/** Whether the wire is there. */
bool lx_can_is_up(const struct lx_can *self);

/** Close any of them; NULL is fine. */
void lx_can_close(struct lx_can *self);

/** The encoders wait, or do not any more: meanwhile nothing comes in, either. */
void lx_can_crowd(struct lx_can *self, bool crowded);

/** Whether nothing may come in at present. */
static inline bool lx_can_is_paused(const struct lx_can *self)
{
    return self->stalled || self->crowded;
}

/** Send a frame. Keeps the order, does not block, does not call back. */
void lx_can_send(struct lx_can *self, const struct dg_can_frame *frame);

/** Forget what waits to be sent. */
void lx_can_discard(struct lx_can *self);

/** For the kinds: open one of these. @return NULL with one line in `error` */
struct lx_can *lx_can_make(const struct lx_can_kind *kind, const struct lx_can_setup *setup,
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
