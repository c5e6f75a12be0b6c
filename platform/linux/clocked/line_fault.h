/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What wire faults do to the SLO of a BiSS encoder. They sit behind its driver: the encoder itself
 * works, its neighbour or the master sees something else.
 */
#ifndef DREHGEBER_LINUX_LINE_FAULT_H
#define DREHGEBER_LINUX_LINE_FAULT_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/biss.h"
#include "drehgeber/fault.h"

/** Longest delay of a start bit, in clocks. */
#define LX_LINE_FAULT_DELAY_MAX 255u

/** The faults of the present frame. All zero: none. */
struct lx_line_fault {
    bool active;     /**< anything of this */
    bool high;       /**< cut, or the driver is dead for this frame */
    bool started;    /**< the start bit has been */
    uint8_t delay;   /**< of what comes behind e1, in clocks */
    uint8_t flip;    /**< which bit behind the start bit is flipped; 0: none */
    uint16_t bit;    /**< on the line now, 0: the start bit */
    uint16_t clocks; /**< since the frame began */
    bool held[LX_LINE_FAULT_DELAY_MAX + 1u]; /**< by clock, modulo its size */
};

/**
 * A frame begins, before its e1: which faults happen to it.
 * @param faults NULL: none
 * @param clock a period of MA; a delay is a whole number of them, 1 at least
 */
void lx_line_fault_begin(struct lx_line_fault *self, struct dg_faults *faults, uint8_t data_bits,
                         dg_ns clock);

/** A rising edge has put SLO to `raw`. */
void lx_line_fault_advance(struct lx_line_fault *self, bool raw);

/** The timeout is over: SLO is high, whatever was to come. A cut wire stays cut. */
void lx_line_fault_end(struct lx_line_fault *self, const struct dg_faults *faults);

/** What is on the other side of the fault while SLO is at `raw`. */
bool lx_line_fault_level(const struct lx_line_fault *self, bool raw);

#endif
