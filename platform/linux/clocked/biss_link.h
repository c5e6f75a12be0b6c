/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What wire faults do to the SLO of a BiSS encoder. They sit behind its driver: the encoder itself
 * works, its neighbour or the master sees something else.
 */
#ifndef DREHGEBER_LINUX_BISS_LINK_H
#define DREHGEBER_LINUX_BISS_LINK_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/biss.h"
#include "drehgeber/fault.h"

/** Longest delay of a start bit, in clocks. */
#define LX_BISS_DELAY_MAX 255u

/** The faults of the present frame. All zero: none. */
struct lx_biss_link {
    bool active;                       /**< anything of this */
    bool high;                         /**< cut, or the driver is dead for this frame */
    bool started;                      /**< the start bit has been */
    uint8_t delay;                     /**< of what comes behind e1, in clocks */
    uint8_t flip;                      /**< which bit behind the start bit is flipped; 0: none */
    uint16_t bit;                      /**< on the line now, 0: the start bit */
    uint16_t clocks;                   /**< since the frame began */
    bool held[LX_BISS_DELAY_MAX + 1u]; /**< by clock, modulo its size */
};

/**
 * A frame begins, before its e1: which faults happen to it.
 * @param faults NULL: none
 * @param clock a period of MA; a delay is a whole number of them, 1 at least
 */
void lx_biss_link_begin(struct lx_biss_link *self, struct dg_faults *faults, uint8_t data_bits,
                        dg_ns clock);

/** A rising edge has put SLO to `raw`. */
void lx_biss_link_advance(struct lx_biss_link *self, bool raw);

/** The timeout is over: SLO is high, whatever was to come. A cut wire stays cut. */
void lx_biss_link_end(struct lx_biss_link *self, const struct dg_faults *faults);

/** What is on the other side of the fault while SLO is at `raw`. */
bool lx_biss_link_level(const struct lx_biss_link *self, bool raw);

#endif
