/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Motion sources for the host side: where a shaft is, as a pure function of time. Evaluated at
 * `now`, never stepped, so nothing drifts in hours of virtual time, and any moment can be asked
 * for in any order.
 *
 * A motion plugs into a world: `world.angle = dg_motion_angle` and `world.angle_ctx = &motion`
 */
#ifndef DREHGEBER_MOTION_H
#define DREHGEBER_MOTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/angle.h"
#include "drehgeber/api.h"
#include "drehgeber/time.h"
#include "drehgeber/wide.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Highest speed of a motion, in 0.001 rpm (1 000 000 rpm). */
#define DG_MOTION_SPEED_MAX_MRPM 1000000000

/** Longest ramp (one hour) and longest sine period (one day). */
#define DG_MOTION_RAMP_MAX DG_S(3600)
#define DG_MOTION_PERIOD_MAX DG_S(86400)

/** What a motion does from `start` on. */
enum dg_motion_kind {
    DG_MOTION_STANDSTILL, /**< stays at `from` */
    DG_MOTION_SPEED,      /**< turns at `mrpm` for good */
    DG_MOTION_RAMP,       /**< trapezoid: 0 to `mrpm` in `accel`, `hold`, back to 0 in `accel` */
    DG_MOTION_SINE,       /**< from + amplitude * sin(2 pi t / period) */
    DG_MOTION_REPLAY,     /**< straight lines between points, at rest outside them */
    DG_MOTION_KIND_COUNT
};

/** A point of a recorded motion. */
struct dg_motion_point {
    dg_ns at;       /**< since the motion's start; strictly increasing from point to point */
    dg_angle angle; /**< absolute */
};

/**
 * What dg_motion_angle() multiplies by where it would divide: made by dg_motion_set() of the
 * figures that the motion has then, and made anew for every angle of a motion that has others, or
 * none yet.
 */
struct dg_motion_ready {
    struct dg_reciprocal by; /**< of ... */
    dg_ns of;                /**< ... accel or period */
    int32_t mrpm;
    uint16_t rate[8]; /**< of `mrpm`: units of 2^-32 turn in 2^-20 ns, times 2^128, rounded up; the
                           lowest 16 bits first */
};

/** A motion. Plain data; a replay's points are borrowed and must outlive it. */
struct dg_motion {
    enum dg_motion_kind kind;
    dg_ns start;        /**< before it, the motion is at its first angle */
    dg_angle from;      /**< angle at `start` (sine: the centre) */
    int32_t mrpm;       /**< speed; ramp: the speed reached. 0.001 rpm, positive clockwise */
    dg_ns accel;        /**< ramp: time from standstill to `mrpm`, and back */
    dg_ns hold;         /**< ramp: time at `mrpm` before it slows down; DG_NEVER: for good */
    dg_angle amplitude; /**< sine */
    dg_ns period;       /**< sine */
    const struct dg_motion_point *points; /**< replay */
    size_t point_count;
    struct dg_motion_ready ready;
};

/**
 * Take over `wanted` when every field its kind uses is in range:
 *  - speed, ramp: mrpm +-DG_MOTION_SPEED_MAX_MRPM
 *  - ramp: accel 1 ns..DG_MOTION_RAMP_MAX; hold DG_NEVER never slows down
 *  - sine: amplitude +-2^40 (256 turns), period 1 ns..DG_MOTION_PERIOD_MAX
 *  - replay: 1 point or more, `at` strictly increasing
 * `wanted->ready` is not looked at.
 * @return DG_OK, or DG_ERR_ARGUMENT with `self` unchanged
 */
DG_API int dg_motion_set(struct dg_motion *self, const struct dg_motion *wanted);

/**
 * Where the shaft is at `now`. `ctx` is a struct dg_motion; the signature is dg_world.angle's.
 * Standstill and constant speed are exact (floor to 2^-32 turn); a ramp is exact to 2^-32 turn
 * plus 2^-20 ns of travel; a sine to 2^-29 of its amplitude plus 2^-32 turn; a replay floors its
 * interpolation. A motion that leaves the range of dg_angle wraps modulo 2^64.
 */
DG_API dg_angle dg_motion_angle(void *ctx, dg_ns now);

#ifdef __cplusplus
}
#endif

#endif
