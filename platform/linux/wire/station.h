/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder on a wire, as a port holds it: where it is in the engine (drehgeber/rig_engine.h), its
 * EEPROM and its power. How it speaks is the wire's.
 */
#ifndef DREHGEBER_LINUX_STATION_H
#define DREHGEBER_LINUX_STATION_H

#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/rig.h"
#include "image.h"

struct lx_bus;
struct lx_bus_setup;

/** An encoder on a bus. The engine makes it; what is control.device is there when the encoder is
    switched on, not before. Not to be moved. */
struct lx_station {
    struct dg_encoder *control; /**< the engine's, as is the handle */
    struct dg_host *host;
    const struct dg_plan_encoder *plan;
    struct lx_bus *bus; /**< NULL until that is made */
    size_t place;       /**< on the bus, 0 is the first */
    /** Rows of the port's own and what they set, for who makes the bus (dg_engine_setup.rows). */
    struct dg_keys rows;
    void *base;
    struct lx_image image; /**< its EEPROM, unless several share one: */
    struct lx_image_part memory;
    const struct lx_nvm_queue *queue; /**< in front of its EEPROM file; NULL: it has none */
    dg_ns ready; /**< from when on lx_bus_ops.read() has something to say; set by open() */
};

/** Its index in the plan. */
size_t lx_station_index(const struct lx_station *self, const struct lx_bus_setup *bus);

/** Load its EEPROM, switch it on at `now`. `settled`, `ctx`: as in lx_image_setup. The bus of the
 * library hears of it by dg_bus_changed(), not here.
 * @return 0, or -1 with `error` */
int lx_station_open(struct lx_station *self, const struct lx_bus_setup *bus,
                    void (*settled)(void *ctx, dg_ns now), void *ctx, dg_ns now,
                    struct lx_error *error);

/** Switch it off, close its EEPROM; also after a failure, or when it was never on. */
void lx_station_close(struct lx_station *self);

#endif
