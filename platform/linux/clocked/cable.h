/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The cable of a simulated clocked wire: levels of the data line on their way to the master. The
 * clock needs the same time to the encoders.
 */
#ifndef DREHGEBER_LINUX_CABLE_H
#define DREHGEBER_LINUX_CABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "drehgeber/time.h"

/** Longest delay each way: 1 km at 5 ns/m. */
#define LX_CABLE_DELAY_MAX_NS 5000u
/** Changes that are on their way at most: one for each clock of 10 MHz, there and back, and some
 * for timeouts and power. */
#define LX_CABLE_CHANGES (2u * LX_CABLE_DELAY_MAX_NS / 100u + 16u)

/** A level from `at` on, at the master's end. */
struct lx_cable_change {
    dg_ns at;
    bool level;
};

/** A cable. */
struct lx_cable {
    dg_ns delay; /**< each way */
    dg_ns fell;  /**< when the latest change from high to low arrives; 0: there was none */
    bool sent;   /**< at the encoders' end */
    bool level;  /**< at the master's end, of all that was taken */
    size_t first;
    size_t count;
    struct lx_cable_change coming[LX_CABLE_CHANGES]; /**< a ring, in the order of arrival */
};

/** Data is at `level` on all of it, and nothing is on its way. `delay` is LX_CABLE_DELAY_MAX_NS
 * at most. */
void lx_cable_init(struct lx_cable *self, dg_ns delay, bool level);

/** At the encoders' end data is at `level` from `now` on. */
void lx_cable_put(struct lx_cable *self, dg_ns now, bool level);

/** The next change that arrives at the master up to `until`. @return false: none */
bool lx_cable_take(struct lx_cable *self, dg_ns until, struct lx_cable_change *change);

/** What the master will see at `at`, not before what was taken, as far as it is on its way. */
bool lx_cable_level(const struct lx_cable *self, dg_ns at);

#endif
