/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What wire faults do to the data line of one encoder. They sit behind its driver: the encoder
 * itself works, its neighbour or the master sees something else.
 */
#ifndef DREHGEBER_LINUX_LINE_FAULT_H
#define DREHGEBER_LINUX_LINE_FAULT_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/fault.h"

/** Longest delay, in clocks. */
#define LX_LINE_FAULT_DELAY_MAX 255u

/** What a frame looks like to them; clocks are rising edges. */
struct lx_line_frame {
    uint8_t lead;  /**< clocks that a frame begins with and that are never late */
    bool waits;    /**< behind them the line is low up to the start bit, which is high; otherwise
                        it is high, and the data follows at once */
    uint8_t ahead; /**< bits between the start bit and the data */
    uint8_t bits;  /**< of the data */
    bool open;     /**< what a line reads as that nobody drives */
    dg_ns delay;   /**< of DG_WIRE_DELAY */
};

/** The faults of the present frame. All zero: none, ever. */
struct lx_line_fault {
    struct lx_line_frame frame;
    struct dg_faults *faults; /**< NULL: none */
    bool active;              /**< anything of what follows */
    bool cut;                 /**< or the driver is dead for this frame */
    bool started;             /**< the start bit has been */
    uint8_t delay;            /**< of what comes behind the lead, in clocks */
    uint8_t flip;             /**< which bit behind the start bit is flipped; 0: none */
    uint16_t bit;             /**< on the line now, 0: the start bit */
    uint16_t clocks;          /**< since the frame began */
    bool held[LX_LINE_FAULT_DELAY_MAX + 1u]; /**< by clock, modulo its size */
};

/** Whether it has to be asked at all. */
static inline bool lx_line_fault_due(const struct lx_line_fault *self)
{
    return self->active || (self->faults != NULL && self->faults->wire != 0);
}

/** A frame begins, before its first clock: which faults happen to it. `period` is that of the
 * clock; a delay is a whole number of them, 1 at least. */
void lx_line_fault_begin(struct lx_line_fault *self, dg_ns period);

/** In this frame, whatever else happens to it, the encoder's driver is dead. */
void lx_line_fault_kill(struct lx_line_fault *self);

/** A rising edge has put the line to `raw`. */
void lx_line_fault_advance(struct lx_line_fault *self, bool raw);

/** The frame is over, whatever was to come. A line that is cut stays cut. */
void lx_line_fault_end(struct lx_line_fault *self);

/** What is on the other side of the fault while the line is at `raw`. */
bool lx_line_fault_level(const struct lx_line_fault *self, bool raw);

#endif
