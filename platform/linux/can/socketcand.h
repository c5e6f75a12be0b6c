/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The protocol of socketcand (doc/protocol.md of its source), seen from the daemon: messages of a
 * client in, replies and frames out. No I/O. Of its modes there are "no bus", BCM without cyclic
 * jobs and filters, and raw; a bus is opened once.
 */
#ifndef DREHGEBER_LINUX_SOCKETCAND_H
#define DREHGEBER_LINUX_SOCKETCAND_H

#include "can.h"

/** Longest message of a client, between '<' and '>'. */
#define LX_SOCKETCAND_MAX 96u
/** Longest message of the daemon, with its zero. */
#define LX_SOCKETCAND_TEXT_MAX 64u
/** Identifiers of 11 bits, a bit for each. */
#define LX_SOCKETCAND_IDS (0x800u / 8u)

/** What a client is told, and may do. */
enum lx_socketcand_mode {
    LX_SOCKETCAND_NO_BUS, /**< nothing */
    LX_SOCKETCAND_BCM,    /**< of frames it has subscribed to; it may send */
    LX_SOCKETCAND_RAW,    /**< of all frames; it may send */
};

/** A client. All zero is one that has just come. */
struct lx_socketcand {
    enum lx_socketcand_mode mode;
    bool inside;    /**< behind a '<' */
    bool overlong;  /**< the message is too long: nothing of it counts */
    uint8_t length; /**< of `text` */
    char text[LX_SOCKETCAND_MAX + 1u];
    uint8_t wanted[LX_SOCKETCAND_IDS]; /**< subscriptions */
};

/** What a message leads to. */
struct lx_socketcand_event {
    const char *reply; /**< NULL: none */
    bool has_frame;    /**< it sends `frame` */
    struct lx_can_wide frame;
};

/** For who has come. */
extern const char lx_socketcand_hello[];

/** A byte came in. `bus` is the one name that a bus can be opened by; "": any.
 * @return true when it completes a message; `event` is set then */
bool lx_socketcand_feed(struct lx_socketcand *self, const char *bus, uint8_t byte,
                        struct lx_socketcand_event *event);

/** Whether it is to be told of a frame. */
bool lx_socketcand_wants(const struct lx_socketcand *self, const struct lx_can_wide *frame);

/** The message that tells of a frame. @return its length in `to` */
size_t lx_socketcand_print(const struct lx_can_wide *frame, dg_ns now,
                           char to[LX_SOCKETCAND_TEXT_MAX]);

#endif
