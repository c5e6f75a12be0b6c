/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The world an encoder lives in. The host owns it, turns the shaft and bends the quantities; the
 * device only reads it, and finds its own error codes. A defect is a cause here, never a code.
 *
 * Every change takes effect at the next moment the device looks. One world may be shared by
 * several encoders on one shaft. It must outlive every device it was handed to.
 */
#ifndef DREHGEBER_WORLD_H
#define DREHGEBER_WORLD_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/angle.h"
#include "drehgeber/api.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a shaft does from a moment on, until somebody turns it; who stands is slow, too. */
enum dg_calm {
    DG_CALM_UNKNOWN, /**< it may do anything */
    DG_CALM_SLOW,    /**< it turns at DG_CALM_MRPM at most, either way, and does not jump */
    DG_CALM_STANDS,  /**< it does not turn */
    DG_CALM_COUNT
};

/** Below each speed at which a device of this library warns, in 0.001 rpm. */
#define DG_CALM_MRPM 3900000

/** Everything the encoders of this library sense. */
struct dg_world {
    /**
     * The shaft's angle as a pure function of time; positive is clockwise. Called at the latch
     * moment the protocol defines, and for the speed also 1 ms earlier (at 0 and at 1 ms when the
     * latch moment is earlier than 1 ms). Must not block.
     */
    dg_angle (*angle)(void *ctx, dg_ns now);
    void *angle_ctx; /**< handed to `angle` and `calm` */
    /**
     * What the shaft has done for DG_WORLD_SPEED_SPAN at `now`, and does until somebody turns it.
     * A host that sets this calls its encoders after each change in here, and when the shaft stops
     * being as calm as it was. In between, encoders do not look for what cannot have changed. NULL:
     * nobody knows.
     */
    enum dg_calm (*calm)(void *ctx, dg_ns now);
    int32_t temperature_mdegc;       /**< in the housing, 0.001 degC; healthy: 37 000 */
    uint32_t led_current_ua;         /**< of the optical scanner; healthy: 12 000 */
    uint32_t supply_mv;              /**< healthy: 5 000 */
    uint32_t battery_mv;             /**< of the multiturn counter; healthy: 3 610 */
    uint16_t sin_amplitude_permille; /**< of the nominal amplitude, 0..2000; healthy: 1000 */
    uint16_t cos_amplitude_permille; /**< likewise */
    int16_t sin_offset_permille;     /**< of the nominal amplitude, -1000..1000; healthy: 0 */
    int16_t cos_offset_permille;     /**< likewise */
    bool singleturn_ok;              /**< the singleturn track can be read */
    bool multiturn_amplitude_ok;     /**< the multiturn sensor's amplitude is sufficient */
    bool multiturn_sync_ok;          /**< multiturn and singleturn agree */
    bool multiturn_vector_ok;        /**< the multiturn sensor's vector length is in range */
    bool eeprom_acknowledges;        /**< the EEPROM answers on its I2C bus */
    bool watchdog_fired;             /**< the watchdog has reset the processor */
};

/** Healthy defaults, the shaft at rest at angle 0. */
DG_API void dg_world_init(struct dg_world *self);

/** The span over which dg_world_speed_mrpm() looks back. */
#define DG_WORLD_SPEED_SPAN DG_MS(1)

/** The shaft's angle at `now`. */
DG_API dg_angle dg_world_angle(const struct dg_world *self, dg_ns now);

/**
 * Mean speed over the millisecond before `now` (over the first millisecond when `now` is earlier
 * than that), in 0.001 rpm, truncated towards 0, positive clockwise; saturates at +-(2^31-1).
 * Modulo the range of dg_angle, so it is right where an angle wraps. An angle that is itself
 * floored to 2^-32 turn can make the result 1 too small or too large (dg_motion_angle does).
 */
DG_API int32_t dg_world_speed_mrpm(const struct dg_world *self, dg_ns now);

/** dg_world_speed_mrpm(), and the `angle` at `now`: for who wants both, as each one costs a motion.
 */
DG_API int32_t dg_world_moving(const struct dg_world *self, dg_ns now, dg_angle *angle);

/** How calm the shaft stays, while nothing in here changes, until the device is called. */
DG_API enum dg_calm dg_world_calm(const struct dg_world *self, dg_ns now);

/** What a monitor of the scanner's signals takes for good ones. */
struct dg_signal_limits {
    uint16_t amplitude_min_permille;
    uint16_t amplitude_max_permille;
    int16_t offset_max_permille; /**< to either side */
};

/** Whether sine and cosine are both within the limits. */
DG_API bool dg_world_signals_ok(const struct dg_world *self, const struct dg_signal_limits *limits);

#ifdef __cplusplus
}
#endif

#endif
