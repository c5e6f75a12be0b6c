/* SPDX-License-Identifier: MIT */
/**
 * @file
 * When the cycles of a ring are run. Each has its moment, `period` after the one before; but a
 * cycle that nobody could notice is only counted, and the others are made up for when somebody
 * looks, or when one of them does something by itself (stores a parameter, feels the watchdog).
 * Whoever looks sees what he would see if each cycle had been run at its moment. A ring that is
 * watched cycles in real time: what is late then is left out and counted.
 */
#ifndef DREHGEBER_LINUX_MODBUS_TIME_H
#define DREHGEBER_LINUX_MODBUS_TIME_H

#include "modbus_map.h"

/** What it takes. */
struct lx_ring_time_setup {
    struct lx_map *map; /**< of the ring */
    dg_ns period;
    /** Run a cycle of the ring at `now`, behind the watchdog's tick. */
    void (*drive)(void *ctx, dg_ns now);
    void *ctx;
};

/** A ring's time. */
struct lx_ring_time {
    struct lx_ring_time_setup setup;
    dg_ns next;   /**< cycle to come; DG_NEVER before the first one */
    bool stirred; /**< something was done to the ring since: the next one has to be run */
    bool watched; /**< each one is run, in real time */
};

/** No cycle yet; the first one is when lx_ring_time_due() is called first. */
void lx_ring_time_init(struct lx_ring_time *self, const struct lx_ring_time_setup *setup);

/** Before anybody looks at the ring or does something to it: what it has come to at `now`. */
void lx_ring_time_to(struct lx_ring_time *self, dg_ns now);

/** Something was done to the ring, its images, its devices or their worlds. */
void lx_ring_time_stir(struct lx_ring_time *self);

/** From `now` on it is watched, or not any more. */
void lx_ring_time_watch(struct lx_ring_time *self, bool watched, dg_ns now);

/** While a cycle is run: behind it nobody watches any more. */
void lx_ring_time_unwatch(struct lx_ring_time *self);

/** When lx_ring_time_due() has to be called; DG_NEVER: nothing is to come. */
dg_ns lx_ring_time_next(const struct lx_ring_time *self);

/** That time has come. */
void lx_ring_time_due(struct lx_ring_time *self, dg_ns now);

#endif
