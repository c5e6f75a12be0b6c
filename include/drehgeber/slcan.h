/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The Lawicel ASCII protocol (SLCAN), seen from the adapter: lines of a master in, replies and
 * frames out. No I/O: for whichever serial line a host has, a pty as well as the USB of a board. An
 * object of its own, that an image without SLCAN does not carry.
 */
#ifndef DREHGEBER_SLCAN_H
#define DREHGEBER_SLCAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/canopen.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest line of a master, without its CR. */
#define DG_SLCAN_LINE_MAX 30u
/** Longest line of the adapter: t, CAN-ID, length, 8 bytes, time stamp, CR. */
#define DG_SLCAN_TEXT_MAX 26u

/** The adapter's CAN channel. */
enum dg_slcan_state {
    DG_SLCAN_CLOSED,
    DG_SLCAN_OPEN,
    DG_SLCAN_LISTENING, /**< open, but the master may not send */
};

/** An adapter. All zero is one that has just been plugged in. */
struct dg_slcan {
    enum dg_slcan_state state;
    uint16_t kbaud; /**< bit rate the master has chosen; 0: none yet */
    bool stamps;    /**< frames end with the time */
    bool overlong;  /**< the line is too long: nothing of it counts */
    uint8_t length; /**< of `line` */
    char line[DG_SLCAN_LINE_MAX];
};

/** What a line of the master leads to. */
struct dg_slcan_event {
    const char *reply; /**< to the master, before anything that the frame causes */
    bool has_frame;    /**< the master sends `frame` */
    bool extended; /**< the master sends a frame with a 29-bit identifier, of which only `rtr` and
                        `dlc` are in `frame` */
    struct dg_can_frame frame;
};

/** A byte came in. @return true when it completes a line; `event` is set then */
DG_API bool dg_slcan_feed(struct dg_slcan *self, uint8_t byte, struct dg_slcan_event *event);

/** Drop the beginning of a line. */
DG_API void dg_slcan_resync(struct dg_slcan *self);

/**
 * The line that tells the master about a frame.
 * @param ms the time, for masters that want stamps
 * @return bytes in `text`, which has room for DG_SLCAN_TEXT_MAX + 1 (the last one is a zero)
 */
DG_API size_t dg_slcan_print(const struct dg_slcan *self, const struct dg_can_frame *frame,
                             uint64_t ms, char *text);

#ifdef __cplusplus
}
#endif

#endif
