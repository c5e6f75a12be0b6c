/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The channel of an SLCAN adapter, whatever leads to its master: a pty (slcan_pty.c), a TCP client
 * (slcan_net.c).
 */
#ifndef DREHGEBER_LINUX_SLCAN_CHANNEL_H
#define DREHGEBER_LINUX_SLCAN_CHANNEL_H

#include "can.h"
#include "drehgeber/slcan.h"

/** A channel. All zero is one of an adapter that has just been plugged in. */
struct lx_slcan_channel {
    struct dg_slcan codec;
    bool mismatch; /**< its bit rate is not the encoders', and the user has been told */
};

/** Tell the user, once per episode, which bit rate would be right: that of the encoders. */
void lx_slcan_check(struct lx_slcan_channel *self, const struct lx_say *say, uint16_t expected);

/** What a line led to, behind its reply: a frame for the encoders, time on the wire, or with
 * `switched` a channel that is open or closed now. */
void lx_slcan_act(struct lx_slcan_channel *self, struct lx_can *can, dg_ns now,
                  const struct dg_slcan_event *event, bool switched);

#endif
