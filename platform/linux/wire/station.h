/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder on a wire, as a port holds it: what the plan says of it, its handle with the settings,
 * its EEPROM and its power. How it speaks is the wire's.
 */
#ifndef DREHGEBER_LINUX_STATION_H
#define DREHGEBER_LINUX_STATION_H

#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/rig.h"
#include "image.h"

struct lx_bus;
struct lx_bus_setup;

/** An encoder on a bus. The rig owns it; the bus fills control.nvm, and control.device when the
    encoder is switched on, not before. Not to be moved while it is. */
struct lx_station {
    struct dg_encoder control; /**< name, model, kind, world and shaft are set before make() */
    struct dg_world world;     /**< what control.world points to; healthy before make() */
    const struct dg_plan_encoder *plan;
    struct lx_bus *bus;
    size_t place;          /**< on the bus, 0 is the first */
    struct dg_host *host;  /**< owned; NULL: it has none, or not yet */
    struct lx_image image; /**< its EEPROM, unless several share one: */
    struct lx_image_part memory;
    const struct lx_nvm_queue *queue; /**< in front of its EEPROM file; NULL: it has none */
    dg_ns ready; /**< from when on lx_bus_ops.read() has something to say; set by open() */
};

/**
 * Make its handle with what the plan says, without power.
 * @param settings of its struct lx_stack, where they are more than the handle's; NULL: they are not
 * @return 0, or -1 with `error`, then close
 */
int lx_station_make(struct lx_station *self, const struct lx_bus_setup *bus, void *settings,
                    struct lx_error *error);

/** Load its EEPROM, switch it on at `now`. `settled`, `ctx`: as in lx_image_setup.
 * @return as above */
int lx_station_open(struct lx_station *self, const struct lx_bus_setup *bus,
                    void (*settled)(void *ctx, dg_ns now), void *ctx, dg_ns now,
                    struct lx_error *error);

/** Switch it off, close its EEPROM, give the handle back; also after a failure, or when it has
 * none. */
void lx_station_close(struct lx_station *self);

#endif
