/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Lanes: packed buses of a rig that are stepped beside each other.
 *
 * Nothing on such a bus concerns another one but through what moves at its own moments: shafts,
 * worlds, faults, commands. All of that is the loop's, and a moment at which it does something is a
 * barrier: every lane is taken up to it first, and stands still meanwhile.
 *
 *   loop      |step ......|turn.........|fault......|end of step
 *   lane 0     frames, deadlines|.......|...........|
 *   lane 1     ...              |.......|...........|
 *
 * A lane has its own strand of time and its own part of the messages that came. Each bus does the
 * same whatever lane it is in, and what it sends waits in its own message for the end of the step,
 * when the loop publishes all of them in the order of the buses. So nothing depends on how many
 * lanes there are.
 *
 * A bus that somebody listens to (a trace, --verbose, TRACe:LAST?) is the loop's as long as that
 * lasts.
 */
#ifndef DREHGEBER_LINUX_SILKIT_LANES_H
#define DREHGEBER_LINUX_SILKIT_LANES_H

#include "drehgeber/time.h"
#include "error.h"

struct lx_silkit;
struct lx_silkit_lanes;

/** Spread the packed buses over self->threads lanes, the first of which is the loop's thread.
 * @return 0, or -1 with `error` */
int lx_silkit_lanes_open(struct lx_silkit *self, struct lx_error *error);

/** A step begins: messages for buses in lanes that are handled in it go there. `self->pending` is
 * sorted. */
void lx_silkit_lanes_begin(struct lx_silkit *self);

/** Take all lanes to `until`: deadlines up to then, messages of the simulation's times before
 * `end`. */
void lx_silkit_lanes_run(struct lx_silkit *self, dg_ns until, uint64_t end);

/** End the threads, give the messages back; the loop's time is that of all buses again. NULL lanes
 * are fine. */
void lx_silkit_lanes_end(struct lx_silkit *self);

/** Give the lanes back, when the buses are closed. */
void lx_silkit_lanes_free(struct lx_silkit *self);

#endif
