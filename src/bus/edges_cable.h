/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The cable of a clocked line: levels of data on their way to the master.
 */
#ifndef DREHGEBER_CABLE_H
#define DREHGEBER_CABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/bus_edges.h"
#include "drehgeber/time.h"

/** Changes that are on their way at most: one for each clock of 10 MHz, there and back, and some
 * for timeouts and power. */
#define DG_BUS_CABLE_CHANGES (2u * DG_BUS_CABLE_MAX_NS / 100u + 16u)

/** A level from `at` on, at the master's end. */
struct dg_bus_cable_change {
    dg_ns at;
    bool level;
};

/** A cable. */
struct dg_bus_cable {
    dg_ns fell;    /**< when the latest change from high to low arrives; 0: there was none */
    uint32_t back; /**< ns from the encoders' end to the master */
    bool sent;     /**< at the encoders' end */
    bool level;    /**< at the master's end, of all that was taken */
    uint16_t first;
    uint16_t count;
    struct dg_bus_cable_change coming[DG_BUS_CABLE_CHANGES]; /**< a ring, in the order of arrival */
};

/** Data is at `level` on all of it, and nothing is on its way. */
void dg_bus_cable_init(struct dg_bus_cable *self, uint32_t back, bool level);

/** At the encoders' end data is at `level` from `now` on. */
void dg_bus_cable_put(struct dg_bus_cable *self, dg_ns now, bool level);

/** The next change that arrives at the master up to `until`. @return false: none */
bool dg_bus_cable_take(struct dg_bus_cable *self, dg_ns until, struct dg_bus_cable_change *change);

/** What the master will see at `at`, not before what was taken, as far as it is on its way. */
bool dg_bus_cable_level(const struct dg_bus_cable *self, dg_ns at);

#endif
