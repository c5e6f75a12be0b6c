/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Bit times of CAN frames, and how much of a bus they take. No I/O, no clock.
 */
#ifndef DREHGEBER_LINUX_CAN_LOAD_H
#define DREHGEBER_LINUX_CAN_LOAD_H

#include "drehgeber/canopen.h"

/**
 * Most bits that frames take on the wire, from SOF to the third bit of the pause behind them, with
 * as many stuff bits as there can be. A frame of n bytes with g bits before and in its CRC that are
 * stuffed has at most g + 8n + 13 + floor((g + 8n - 1) / 4): with 11-bit identifiers g = 34 and
 * that is 55 + 10n, with 29-bit ones g = 54 and 80 + 10n (Davis, Burns, Bril, Lukkien: Controller
 * Area Network (CAN) schedulability analysis: Refuted, revisited and revised, Real-Time Systems 35,
 * 2007). With 8 bytes 135 bits: 13.5 ms at 10 kBd, where the manual asks for 14 ms (chapter 8).
 * Both are linear, so sums over frames and their bytes are exact as well.
 */
#define LX_CAN_BITS(frames, bytes) (55u * (frames) + 10u * (bytes))
#define LX_CAN_EXTENDED_BITS(frames, bytes) (80u * (frames) + 10u * (bytes))

/** Bytes of data that a frame carries: none, when it is a remote one. */
static inline uint32_t lx_can_bytes(const struct dg_can_frame *frame)
{
    return frame->rtr ? 0u : frame->dlc;
}

/** Load is measured in pieces of this. */
#define LX_CAN_LOAD_WINDOW DG_S(1)
/** Above this the bus is overloaded, until the load is no more than the other. A frame counts in
 * the window that it begins in, 135 bits at 10 kBd, one of a master in that in which it has come,
 * and a few milliseconds are made up for: up to 32 permille of a window that was full. */
#define LX_CAN_OVERLOAD_PERMILLE 1040u
#define LX_CAN_RELIEF_PERMILLE 900u

/** A bus whose load is measured. */
struct lx_can_load {
    dg_ns since;       /**< when the running window began */
    uint64_t bits;     /**< on the wire until then */
    uint32_t permille; /**< of the latest whole window */
    bool overloaded;
};

/** Measure from `now` on; `bits` have been on the wire so far. */
void lx_can_load_begin(struct lx_can_load *self, dg_ns now, uint64_t bits);

/** Whether the running window is over at `now`. */
static inline bool lx_can_load_due(const struct lx_can_load *self, dg_ns now)
{
    return dg_elapsed(now, self->since) >= LX_CAN_LOAD_WINDOW;
}

/**
 * The running window is over.
 * @param bits on the wire so far, in both directions; less than before: the wire is another one
 * @param bit_rate in bit/s; 0: unknown, then there is no load
 * @return whether an overload begins
 */
bool lx_can_load_take(struct lx_can_load *self, dg_ns now, uint64_t bits, uint32_t bit_rate);

/** The load at `now`, in permille: of the latest whole window, or of the running one when that is
 * over already; only then `bits` count. Parameters as above. */
uint32_t lx_can_load_permille(const struct lx_can_load *self, dg_ns now, uint64_t bits,
                              uint32_t bit_rate);

#endif
