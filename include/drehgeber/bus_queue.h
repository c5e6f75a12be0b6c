/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a bus tells, kept until its host reads it: for bindings of other languages, where a call
 * back costs more than all that the bus does, or cannot be.
 *
 *   struct dg_bus_told told[256];
 *   struct dg_bus_queue queue = {.told = told, .room = 256};
 *   setup.ops = &dg_bus_queue_ops, setup.ctx = &queue
 *
 *   while (dg_bus_step_queued(bus, &queue, now, 128) <= now) { read told[0..count), count = 0 }
 *
 * Such a bus has no slow memory: what its encoders acknowledge is durable.
 */
#ifndef DREHGEBER_BUS_QUEUE_H
#define DREHGEBER_BUS_QUEUE_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus.h"
#include "drehgeber/tap.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Something that a bus has told. */
struct dg_bus_told {
    struct dg_tap_event event; /**< what its pointers lead to is gone */
    uint32_t place;            /**< of its encoder; 0 of what was only looked at */
    bool looked;               /**< told by dg_bus_ops.tap, for who looks; else by dg_bus_ops.tx */
};

/** What waits for the host, oldest first. Whoever has read it puts `count` to 0. */
struct dg_bus_queue {
    struct dg_bus_told *told; /**< in memory of the host's, which outlives the bus */
    uint32_t room;            /**< of so many */
    uint32_t count;
    uint32_t lost; /**< found no room; only counts up */
    dg_ns stepped; /**< private: the latest moment of dg_bus_step_queued() */
};

/** The door, for dg_bus_setup; its ctx is the queue. It tells who looks, too: dg_bus_watch() with
 * false behind dg_bus_init() if nobody does. */
DG_API extern const struct dg_bus_ops dg_bus_queue_ops;

/** As dg_bus_step(), but that it stops when `most` or more wait: what comes at one moment is not
 * torn apart, so that there has to be room for that behind `most` - 1.
 * @return when to call again; not later than `until`: when they have been read */
DG_API dg_ns dg_bus_step_queued(struct dg_bus *bus, struct dg_bus_queue *queue, dg_ns until,
                                uint32_t most);

/** The same until something is told, and on while the next step is not more than `gap` behind what
 * was told last: the characters of a reply. Half of the room ends it, too.
 * @return the moment of the latest step */
DG_API dg_ns dg_bus_step_burst(struct dg_bus *bus, struct dg_bus_queue *queue, dg_ns until,
                               dg_ns gap);

#ifdef __cplusplus
}
#endif

#endif
