/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CAN bus whose nodes, besides the encoders, are TCP clients: each hears the encoders and all
 * others. What they speak is a dialect: SLCAN, socketcand.
 *
 * The bus has one bit rate: the encoders' own when a client has it, else that of the client in the
 * first place that is open. Clients with another one hear nothing, and nobody hears them. 0 is
 * right for everybody.
 */
#ifndef DREHGEBER_LINUX_CAN_NET_H
#define DREHGEBER_LINUX_CAN_NET_H

#include "can.h"
#include "peers.h"

/** Longest text of a frame, in any dialect, with its zero. */
#define LX_CAN_TEXT_MAX 96u

struct lx_can_net;

/** What clients speak. `own` is what a client has, zero at first. */
struct lx_can_dialect {
    const char *kind;
    struct lx_peers_form address;
    size_t own_size;
    const char *hello; /**< for who has come; NULL: nothing is said */
    /** Answer, switch the client on or off, lx_can_net_spread(). */
    void (*byte)(struct lx_can_net *self, struct lx_peer *from, dg_ns now, uint8_t byte);
    /** Whether a client takes part. */
    bool (*is_open)(const void *own);
    /** Whether one that does wants this frame. NULL: it does. */
    bool (*wants)(const void *own, const struct lx_can_wide *frame);
    /** Its bit rate in kBd; 0: any. NULL: there are none. */
    uint16_t (*kbaud)(const void *own);
    /** The encoders' bit rate is another one. NULL: nobody minds. */
    void (*check)(void *own, const struct lx_say *say, uint16_t expected);
    /** A frame as it tells a client. @return its length in `to` */
    size_t (*print)(const void *own, const struct lx_can_wide *frame, dg_ns now,
                    char to[LX_CAN_TEXT_MAX]);
};

/** A bus. */
struct lx_can_net {
    struct lx_can can;
    const struct lx_can_dialect *dialect;
    struct lx_peers_where where;
    struct lx_peers peers;
};

/** Of a kind with such a bus, which names its dialect, too. Its struct is struct lx_can_net. */
extern const struct lx_can_ops lx_can_net_ops;
/** As lx_can_kind.start(). */
int lx_can_net_start(struct lx_can *can, struct lx_error *error);

/** A client sends a frame. @return whether it is on the bus: others with its bit rate are told */
bool lx_can_net_spread(struct lx_can_net *self, const struct lx_peer *from, dg_ns now,
                       const struct lx_can_wide *frame);

#endif
