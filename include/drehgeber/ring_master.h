/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The master of a ring (bus_words.h), for hosts that have no other: it runs cycles with its OUT
 * image, each `period` after the one before, and has a watchdog.
 *
 *   struct dg_ring_master_setup setup = {sizeof setup, bus, out, DG_MS(1)};
 *   dg_ring_master_init(&master, &setup)
 *   dg_ring_master_due(&master, now)      the first cycle, and whenever _next() has come
 *   dg_ring_master_to(&master, now)       before anybody looks at the ring or does something to it
 *   dg_ring_master_stir(&master)          behind that, if something was done
 *
 * A cycle that nobody could notice is only counted. The others are made up for when somebody looks,
 * or when one of them does something by itself (stores a parameter, feels the watchdog). Whoever
 * looks sees what they would see if each cycle had been run at its moment. A ring that is watched
 * cycles in real time: what is late then is left out and counted. So does a ring with a fault of
 * its wire.
 *
 * Time and OUT image are the host's. Nothing happens outside of these calls.
 */
#ifndef DREHGEBER_RING_MASTER_H
#define DREHGEBER_RING_MASTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What happens to OUT when the watchdog has fired. */
enum dg_ring_fallback {
    DG_RING_FALLBACK_ZERO,   /**< OUT becomes 0 */
    DG_RING_FALLBACK_FREEZE, /**< OUT stays */
    DG_RING_FALLBACK_STOP,   /**< data cycles end, IN holds its last value: ID cycles only */
    DG_RING_FALLBACK_COUNT
};

/** The watchdog. dg_ring_master_start() arms it; it fires in the first cycle that comes when it was
 * not fed for longer than its time. */
struct dg_ring_watchdog {
    uint16_t time_ms;  /**< 0: off */
    uint16_t fallback; /**< enum dg_ring_fallback */
    bool armed;
    bool fired;
    dg_ns fed; /**< when it was fed last */
};

/** What a master is made of. Everything pointed to must outlive it. */
struct dg_ring_master_setup {
    size_t size;        /**< sizeof(struct dg_ring_master_setup) */
    struct dg_bus *bus; /**< the ring */
    uint16_t *out; /**< the OUT image, dg_ring_state()->words words: what is in it goes out with
                             the next data cycle */
    dg_ns period;  /**< above 0; 0: the host runs each cycle, by dg_ring_master_cycle() only */
};

/** A master. Plain data; `time_ms`, `fallback` and `fed` of its watchdog are the host's, too. */
struct dg_ring_master {
    struct dg_ring_master_setup setup;
    struct dg_ring_watchdog watchdog;
    bool stopped;    /**< ID cycles only */
    uint32_t missed; /**< cycles that came too late to take place */
    dg_ns next;      /**< cycle to come; DG_NEVER before the first one */
    bool stirred;    /**< something was done to the ring since: the next one has to be run */
    bool watched;    /**< somebody wants each cycle, in real time; */
    bool bent;       /**< ... so does a wire fault, as far as it is known */
};

/** Make one whose watchdog is off. No cycle yet; the first one is when dg_ring_master_due() is
 * called first. */
DG_API void dg_ring_master_init(struct dg_ring_master *self,
                                const struct dg_ring_master_setup *setup);

/** Run a cycle at `now`, whenever it was to be: the watchdog looks at the clock, then comes a data
 * cycle with the images, or an ID cycle while the ring is stopped. @return false: a fault let it
 * not take place */
DG_API bool dg_ring_master_cycle(struct dg_ring_master *self, dg_ns now);

/** Be what the ring has come to at `now`. */
DG_API void dg_ring_master_to(struct dg_ring_master *self, dg_ns now);

/** Something was done to the ring, its images, its encoders or their worlds. */
DG_API void dg_ring_master_stir(struct dg_ring_master *self);

/** The same at `now`, behind dg_ring_master_to(); it may have been to faults of the wire, or to who
 * watches. */
DG_API void dg_ring_master_changed(struct dg_ring_master *self, bool watched, dg_ns now);

/** The IN image, dg_bus_words_setup.in. */
DG_API const uint16_t *dg_ring_master_in(const struct dg_ring_master *self);

/** When dg_ring_master_due() has to be called; DG_NEVER: nothing is to come. */
DG_API dg_ns dg_ring_master_next(const struct dg_ring_master *self);

/** That time has come. */
DG_API void dg_ring_master_due(struct dg_ring_master *self, dg_ns now);

/** The watchdog is fed at `now`; one that has fired does not eat. */
DG_API void dg_ring_master_feed(struct dg_ring_master *self, dg_ns now);

/** OUT was written at `now`: the watchdog is armed and fed. That makes up for one that has fired,
 * and data cycles go on. */
DG_API void dg_ring_master_start(struct dg_ring_master *self, dg_ns now);

/** Make up for a watchdog that has fired without writing OUT: data cycles go on, and it sleeps
 * until the next dg_ring_master_start(). */
DG_API void dg_ring_master_reset(struct dg_ring_master *self);

#ifdef __cplusplus
}
#endif

#endif
