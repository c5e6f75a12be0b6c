/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What wire faults do to the data line of one encoder that a master clocks (BiSS, SSI). They sit
 * behind its driver: the encoder itself works, its neighbour or the master sees something else.
 */
#ifndef DREHGEBER_LINE_FAULT_H
#define DREHGEBER_LINE_FAULT_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/fault.h"
#include "drehgeber/instrument.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest delay, in clocks: 100 us at 10 MHz. */
#define DG_LINE_FAULT_DELAY_MAX 1023u

/** The faults of the present frame. All zero: none, ever. Plain data. */
struct dg_line_fault {
    struct dg_line_frame frame;
    struct dg_faults *faults; /**< NULL: none */
    bool active;              /**< anything of what follows */
    bool cut;                 /**< or the driver is dead for this frame */
    bool started;             /**< the start bit has been */
    bool late;                /**< what comes behind the lead is ... */
    uint16_t delay;           /**< ... by so many clocks; 0: not known yet */
    uint8_t flip;             /**< which bit behind the start bit is flipped; 0: none */
    uint16_t bit;             /**< on the line now, 0: the start bit */
    uint16_t clocks;          /**< since the frame began */
    uint8_t held[(DG_LINE_FAULT_DELAY_MAX + 1u) / 8u]; /**< bits by clock, modulo its size */
};

/** The line of `device`, which has its model. @param instrument one with a line_frame
 * @param faults NULL: none */
DG_API void dg_line_fault_init(struct dg_line_fault *self, const struct dg_instrument *instrument,
                               const void *device, struct dg_faults *faults);

/** Whether it has to be asked at all. */
static inline bool dg_line_fault_due(const struct dg_line_fault *self)
{
    return self->active || (self->faults != NULL && self->faults->wire != 0);
}

/** A frame begins, before its first clock: which faults happen to it. */
DG_API void dg_line_fault_begin(struct dg_line_fault *self);

/** In this frame, whatever else happens to it, the encoder's driver is dead. */
DG_API void dg_line_fault_kill(struct dg_line_fault *self);

/** A rising edge has put the line to `raw`. `period` is that of the clock, ns; a delay is a whole
 * number of them, 1 at least. */
DG_API void dg_line_fault_advance(struct dg_line_fault *self, bool raw, dg_ns period);

/** The frame is over, whatever was to come. A line that is cut stays cut. */
DG_API void dg_line_fault_end(struct dg_line_fault *self);

/** What is on the other side of the fault while the line is at `raw`. */
DG_API bool dg_line_fault_level(const struct dg_line_fault *self, bool raw);

#ifdef __cplusplus
}
#endif

#endif
