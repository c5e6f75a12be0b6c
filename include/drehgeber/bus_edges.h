/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A bus where a master clocks and encoders shift: BiSS, SSI and their like (bus.h).
 *
 *            clock ----> there ----> encoder 0, 1, ...
 *   master
 *            <---- back <---- data of encoder 0 <-- of encoder 1 <-- ...
 *
 * dg_bus_rx() takes DG_TAP_LEVELS: the master's clock is at levels.clock. dg_bus_ops.tx tells
 * levels.data at the master's end, whenever it has changed there. An encoder whose memory is not
 * ready to be answered for (dg_bus_ops.answer) sends nothing in the frame that begins: its line
 * reads as one that nobody drives. Nothing of it is sent later.
 */
#ifndef DREHGEBER_BUS_EDGES_H
#define DREHGEBER_BUS_EDGES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Most encoders on one line. Only those whose protocol makes chains share one. */
#define DG_BUS_CHAIN_MAX 8u
/** Longest way of a level through the cable: 1 km at 5 ns/m. */
#define DG_BUS_CABLE_MAX_NS 5000u

/** dg_bus_setup.wire. NULL instead: no cable, any clock. */
struct dg_bus_edges_setup {
    size_t size;        /**< sizeof(struct dg_bus_edges_setup) */
    uint32_t there_ns;  /**< the clock's way to the encoders, 0..DG_BUS_CABLE_MAX_NS */
    uint32_t back_ns;   /**< data's way to the master, with what drivers take; likewise */
    uint32_t period_ns; /**< of the clock, for faults that take whole clocks; 0: as its edges say */
};

/** The medium: DG_MEDIUM_EDGES. */
DG_API extern const struct dg_bus_medium dg_bus_edges;

/** dg_bus_rx() for hosts where each edge counts: the clock is at `level` from `now` on; the same
 * level again is no edge. When to call again is dg_bus_next()'s to say.
 * @return the level of data at the master's end */
DG_API bool dg_bus_edge(struct dg_bus *self, dg_ns now, bool level);

/** The level of the clock at the master's end; high before the first edge. */
DG_API bool dg_bus_edges_clock(const struct dg_bus *self);
/** The level of data at the master's end at `at`, as far as it is on its way; `at` is not before
 * the latest moment that was served. */
DG_API bool dg_bus_edges_data(const struct dg_bus *self, dg_ns at);
/** When the latest change of data from high to low arrives at the master, or has; 0: there was
 * none. */
DG_API dg_ns dg_bus_edges_fell(const struct dg_bus *self);

/** What the user should know at `now`, as dg_host_hint(): once for the whole line.
 * @param due when to ask again, unless an edge comes before; DG_NEVER: not by itself
 * @return NULL: nothing */
DG_API const char *dg_bus_edges_hint(struct dg_bus *self, dg_ns now, dg_ns *due);

#ifdef __cplusplus
}
#endif

#endif
