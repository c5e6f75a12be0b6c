/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The registers of the bus coupler in front of a ring, its watchdog, and their description.
 * Addresses follow the publicly documented layout of Modbus couplers for fieldbus terminals.
 */
#ifndef DREHGEBER_LINUX_MODBUS_MAP_H
#define DREHGEBER_LINUX_MODBUS_MAP_H

#include <stdio.h>

#include "modbus_ring.h"

/** No register is at or above this address. */
#define LX_MAP_END (0x2000u + 16u * DG_RING_MAX)

/** What happens to OUT when the watchdog has fired (register 1123h). */
enum lx_fallback {
    LX_FALLBACK_ZERO,   /**< OUT becomes 0 */
    LX_FALLBACK_FREEZE, /**< OUT stays */
    LX_FALLBACK_STOP,   /**< data cycles end, IN holds its last value */
    LX_FALLBACK_COUNT
};

/**
 * The watchdog. Armed by the first write to the output image, fed by every request (type 1) or
 * every write to the output image (type 0); fires when it was not fed for its time. A write to the
 * output image, or BECFh and then AFFEh to 1121h, makes up for it.
 */
struct lx_watchdog {
    uint16_t time_ms; /**< 0: off */
    uint16_t type;
    uint16_t fallback; /**< enum lx_fallback */
    uint16_t key;      /**< last value written to 1121h */
    bool armed;
    bool fired;
    dg_ns fed;
};

/** A coupler's registers. */
struct lx_map {
    struct lx_ring *ring;
    struct lx_watchdog watchdog;
    bool tear;       /**< half of an OUT word may be written */
    uint32_t missed; /**< cycles that came too late to take place */
    dg_ns now;       /**< of the request */
};

/** One request's range of registers. */
struct lx_range {
    uint16_t first;
    uint16_t count;
};

/** The registers of `ring`, watchdog off. */
void lx_map_init(struct lx_map *self, struct lx_ring *ring);

/** Whether every register of the range exists. */
bool lx_map_readable(const struct lx_map *self, struct lx_range range);

/** Whether every register of the range may be written, and no OUT word in part (I21). */
bool lx_map_writable(const struct lx_map *self, struct lx_range range);

/** Read a readable range. */
void lx_map_read(const struct lx_map *self, struct lx_range range, uint16_t *to);

/** Write a writable range. @return false: a value is out of range, and nothing was written */
bool lx_map_write(struct lx_map *self, struct lx_range range, const uint16_t *values);

/** A request came in at `now`; call it before the functions above. */
void lx_map_request(struct lx_map *self, dg_ns now);

/** Let the watchdog look at the clock. */
void lx_map_tick(struct lx_map *self, dg_ns now);

/** Before this time it finds nothing to do, if nothing is written or asked for. */
dg_ns lx_map_quiet(const struct lx_map *self);

/** Describe the registers of a ring of these models. */
void lx_map_print(const struct dg_ib_model *const *models, size_t count, FILE *to);

#endif
