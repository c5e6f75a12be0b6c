/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A master of a clocked line (bus_master.h) that reads by itself, for hosts where nobody else
 * clocks: a frame every DG_BUS_READ_EVERY. A frame takes its time on the wire, which may run ahead
 * of the host's time by it; then the next one waits:
 *
 *   time   0        100 ms     200 ms
 *   wire   |frame|  |frame|registers.......|frame|
 *
 * Each frame is read at its own moment, however late the host comes. Frames that nobody can notice
 * are counted and not clocked: when nobody watches, no fault bends the wire, and nothing has
 * happened for a while. Whoever looks then sees what they would have seen otherwise:
 *
 *   stir                      run                  run
 *    v                          v                    v
 *   --x----x----x----o----o----x----o----o----o----x--   x clocked, o counted
 */
#ifndef DREHGEBER_BUS_READER_H
#define DREHGEBER_BUS_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus_master.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How often it reads. */
#define DG_BUS_READ_EVERY DG_MS(100)

/** Things nobody has to act on; they only count up. */
struct dg_bus_reader_counters {
    uint64_t frames; /**< read, or counted */
    uint64_t wrong;  /**< positions with a wrong check sum */
};

/** A reader. Plain data. Between its calls the host may clock, too, with `master`. */
struct dg_bus_reader {
    struct dg_bus_master master; /**< whose `silent` counts on with frames that are counted */
    dg_ns init;                  /**< of the encoder that takes longest to initialise */
    dg_ns due;                   /**< the next frame */
    dg_ns stirred;               /**< frames before that are clocked, whoever looks */
    bool watched;                /**< somebody wants each frame */
    uint32_t silent;             /**< of the latest frame: without an answer, */
    uint64_t bad;                /**< ... positions with a wrong check sum */
    struct dg_bus_reader_counters counters;
};

/** Make one. The first frame is at `now` + `init`, where the encoders initialise for so long at
 * most. */
DG_API void dg_bus_reader_init(struct dg_bus_reader *self, const struct dg_bus_master_setup *setup,
                               dg_ns init, dg_ns now);

/** Somebody wants each frame from now on, and is told what goes over the wire (dg_bus_watch()), or
 * not any more. */
DG_API void dg_bus_reader_watch(struct dg_bus_reader *self, bool watched);

/** Read what was due up to `now`. Of more than a thousand frames that somebody wants the oldest are
 * left out. */
DG_API void dg_bus_reader_run(struct dg_bus_reader *self, dg_ns now);

/** When to run it; DG_NEVER: until something happens nobody could notice a frame. */
DG_API dg_ns dg_bus_reader_next(const struct dg_bus_reader *self);

/** Something was done to the encoders, or by them, at `now`. */
DG_API void dg_bus_reader_stir(struct dg_bus_reader *self, dg_ns now);

/** Read a frame out of turn, at the moment of the master. */
DG_API void dg_bus_reader_read(struct dg_bus_reader *self);

#ifdef __cplusplus
}
#endif

#endif
