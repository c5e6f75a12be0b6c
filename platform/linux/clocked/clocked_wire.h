/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The master's end of a simulated clocked line: every edge of its clock, in virtual time, and when
 * it takes its samples. The wire's time is the master's and runs on by as much as it clocks. What
 * is between it and the encoders is the bus's (drehgeber/bus_edges.h).
 */
#ifndef DREHGEBER_LINUX_CLOCKED_WIRE_H
#define DREHGEBER_LINUX_CLOCKED_WIRE_H

#include <stdbool.h>
#include <stdint.h>

#include "clocked.h"

/** The wire. */
struct lx_clocked_wire {
    struct lx_clocked *line;
    uint32_t edges_per_s; /**< of the clock */
    uint32_t half_ns;     /**< half a period, and */
    uint32_t rest;        /**< what it is longer, in 1 ns / edges_per_s */
    uint32_t owed;        /**< of such rests so far */
    dg_ns now;            /**< at the master's end */
    uint32_t way_ns;      /**< of the cable, there and back */
    bool compensates;     /**< whether the master knows `delay`: it measures it, or it was told */
    dg_ns delay;          /**< there and back: it takes its samples later by that; else 0 */
    uint32_t silent;      /**< frames without an answer; counted up */
};

/** What is between such a master and the encoders, for the bus. */
struct dg_bus_edges_setup lx_clocked_wire_cable(const struct dg_plan_timing *timing);

/** A wire at `now`, its clock high. `line` is connected, its encoders have their power. */
void lx_clocked_wire_init(struct lx_clocked_wire *self, struct lx_clocked *line,
                          const struct dg_plan_timing *timing, dg_ns now);

/** Half a period on, the master puts the clock to `level`. */
void lx_clocked_wire_edge(struct lx_clocked_wire *self, bool level);

/** A falling and a rising edge. @return the bit of this clock: as the master samples it, half a
 * period behind the rising edge and `delay` */
bool lx_clocked_wire_bit(struct lx_clocked_wire *self);

/** Nothing happens until `now`; a moment that is over already is the present one. Faults of the
 * line may have come or gone. */
void lx_clocked_wire_pause(struct lx_clocked_wire *self, dg_ns now);

#endif
