/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A shaft that is steered while it turns: by hand, by a test, by a gear from another shaft. Where
 * it is stays a pure function of time; a command replaces the function from its own moment on.
 *
 * A shaft plugs into worlds: `world.angle = dg_shaft_angle` and `world.angle_ctx = &shaft`
 */
#ifndef DREHGEBER_SHAFT_H
#define DREHGEBER_SHAFT_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/motion.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Greatest acceleration, in 0.001 rpm per second (10^9 rpm/s). */
#define DG_SHAFT_ACCELERATION_MAX INT64_C(1000000000000)
/** Parts of constant acceleration a command can lead to: to a speed, hold it, brake, rest. */
#define DG_SHAFT_PHASES 4u
/** A phase keeps its angle in such parts of 2^-32 turn, 3 * 5^22: 512 of them are 10^-12 rpm for
 * 1 ns, so that no number of commands adds up to a drift. */
#define DG_SHAFT_PARTS UINT64_C(7152557373046875)
/** Shafts between one and the shaft that drives them all, at most. */
#define DG_SHAFT_GEARS_MAX 8u

/** A part of constant acceleration. */
struct dg_shaft_phase {
    dg_ns at;           /**< it begins */
    dg_angle from;      /**< angle there, rounded down ... */
    uint64_t part;      /**< ... and what is missing, 0..DG_SHAFT_PARTS-1 */
    int64_t prpm;       /**< speed there in 10^-12 rpm */
    int64_t mrpm_per_s; /**< acceleration; 0 in the last phase */
};

/** What a shaft does from a command on. */
struct dg_shaft_course {
    dg_ns at;                /**< the command's moment; a play starts its motion's `start` there */
    bool plays;              /**< `motion` says where it is, else the phases */
    struct dg_motion motion; /**< its points are borrowed */
    uint8_t count;           /**< phases; the last one lasts for good */
    struct dg_shaft_phase phase[DG_SHAFT_PHASES];
};

/** A shaft. Caller-owned plain data, but for `driver`; other modules only read it. */
struct dg_shaft {
    struct dg_shaft_course course; /**< in force */
    struct dg_shaft_course before; /**< in force before course.at: encoders look back 1 ms; before
                                        before.at it counts as turning as it did there */
    dg_ns jumped;                  /**< when it last was somewhere else at once */
    int64_t mrpm_per_s;            /**< of velocity, stop and move; 0: at once */
    const struct dg_shaft *driver; /**< NULL: turns by itself */
    int32_t numerator;             /**< geared: turns of this shaft ... */
    int32_t denominator;           /**< ... for as many of the driver; not 0 */
    dg_angle offset;               /**< geared: angle while the driver is at 0 */
};

/** At rest at angle 0, no acceleration limit, no gear. */
DG_API void dg_shaft_init(struct dg_shaft *self);

/**
 * Couple to `driver`, which must outlive this shaft and be declared before it: angle = floor(driver
 * * numerator / denominator) + offset, exact for every angle; offset is 0 to begin with. A geared
 * shaft takes no command but dg_shaft_set_position(), which moves `offset`.
 * @return 0 or DG_ERR_ARGUMENT: no driver, denominator < 1, more than DG_SHAFT_GEARS_MAX gears in a
 * row, or a loop
 */
DG_API int dg_shaft_couple(struct dg_shaft *self, const struct dg_shaft *driver, int32_t numerator,
                           int32_t denominator);

/** Acceleration of the commands to come, 0..DG_SHAFT_ACCELERATION_MAX; 0: at once.
 * @return 0 or DG_ERR_ARGUMENT, also for a geared shaft */
DG_API int dg_shaft_set_acceleration(struct dg_shaft *self, int64_t mrpm_per_s);

/** Be at `angle` at `now`, at rest (a geared shaft goes on turning). @return 0 */
DG_API int dg_shaft_set_position(struct dg_shaft *self, dg_ns now, dg_angle angle);

/** Turn at `mrpm`, reached from the present speed with the acceleration; 0 stops.
 * @return 0; DG_ERR_ARGUMENT beyond +-DG_MOTION_SPEED_MAX_MRPM, or for a geared shaft */
DG_API int dg_shaft_set_velocity(struct dg_shaft *self, dg_ns now, int32_t mrpm);

/** Be at `angle` at `now` and turn on at `prpm`, in 10^-12 rpm, whatever the acceleration: for
 * hosts that know both from elsewhere.
 * @return 0; DG_ERR_ARGUMENT beyond +-DG_MOTION_SPEED_MAX_MRPM, or for a geared shaft */
DG_API int dg_shaft_turn(struct dg_shaft *self, dg_ns now, dg_angle angle, int64_t prpm);

/**
 * Go to `target` and stay there: from the present angle and speed, with the acceleration, at most
 * at `mrpm` > 0 (faster than that at present: only until it has slowed down). Moving away, or too
 * fast to stop before the target, it turns round. Without an acceleration at `mrpm` from the first
 * moment to the last. It ends exactly at `target`, at a whole nanosecond.
 * @return 0; DG_ERR_ARGUMENT: mrpm not in 1..DG_MOTION_SPEED_MAX_MRPM, or a geared shaft
 */
DG_API int dg_shaft_move(struct dg_shaft *self, dg_ns now, dg_angle target, int32_t mrpm);

/** Do what `motion` says from `now` on (its `start` is set to now). @return as dg_motion_set(), or
 * DG_ERR_ARGUMENT for a geared shaft */
DG_API int dg_shaft_play(struct dg_shaft *self, dg_ns now, const struct dg_motion *motion);

/** When the last move, stop or speed change is (or was) over; DG_NEVER while a motion is played.
 * Geared: the driver's. */
DG_API dg_ns dg_shaft_settled(const struct dg_shaft *self);

/** What it has done for DG_WORLD_SPEED_SPAN at `now`, and does until there is a command; of a
 * played sine or replay, and of one that is geared up beyond DG_CALM_MRPM, that is not known. `ctx`
 * is a struct dg_shaft; the signature is dg_world.calm's. */
DG_API enum dg_calm dg_shaft_calm(void *ctx, dg_ns now);

/** Where it is. `ctx` is a struct dg_shaft; the signature is dg_world.angle's. */
DG_API dg_angle dg_shaft_angle(void *ctx, dg_ns now);

/** Its speed at `now` in 0.001 rpm: of the phase, truncated; of a played motion at constant speed
 * the motion's, of another one the mean of the millisecond before (of its first one in that one),
 * to the nearest. Geared: the driver's times the ratio, truncated, saturated. */
DG_API int32_t dg_shaft_mrpm(const struct dg_shaft *self, dg_ns now);

#ifdef __cplusplus
}
#endif

#endif
