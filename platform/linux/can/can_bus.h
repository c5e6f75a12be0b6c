/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders on one bus of the event loop: any models, each with a world, a node-ID and an EEPROM of
 * its own. What happens between them and the wire is dg_bus_frames; here are its door and its time.
 */
#ifndef DREHGEBER_LINUX_CAN_BUS_H
#define DREHGEBER_LINUX_CAN_BUS_H

#include "bus.h"
#include "can.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/host_wire.h"

struct lx_can_bus;

/** An encoder. */
struct lx_can_node {
    struct lx_can_bus *bus;
    struct lx_station *station;
    const struct dg_host_controller *ask; /**< what it tells of itself: */
    const void *device;
    uint32_t id;      /**< node-ID in the delivery state */
    uint32_t version; /**< of what it tells of itself, when `shared` was looked at */
    /** CAN-IDs that two of its services had at the last look; 0: none */
    uint16_t shared[DG_HOST_SHARED];
};

/** A bus. */
struct lx_can_bus {
    struct lx_bus bus;
    struct lx_can *can;
    struct dg_bus_load load; /**< of the wire */
    struct lx_timer timer;
    bool stalled;    /**< the wire had no room when it was looked at last */
    bool told;       /**< the wire knows who listens to what, */
    bool tapped;     /**< ... and that somebody wants to see all there is */
    dg_ns tapped_at; /**< of the frame that the tap was told last */
    dg_ns due;       /**< as the bus has said last */
    size_t same;     /**< stations, from the first one on, that have one shaft */
    unsigned calm;   /**< count_calm() until now: encoders may sleep (world.h) */
    dg_ns promised;  /**< when the encoders want to be called next; while they wait for the wire
                        nobody is: DG_NEVER */
    struct lx_can_node node[]; /**< as many as stations */
};

/* --- a node, can_node.c --- */

/** The station at `place`. */
void lx_can_node_make(struct lx_can_bus *bus, size_t place);

/** Load its EEPROM, switch it on. `settled`: as in lx_image_setup, with the node as ctx.
 * @return 0, or -1 with one line in `error`, then close */
int lx_can_node_open(struct lx_can_node *self, void (*settled)(void *ctx, dg_ns now), dg_ns now,
                     struct lx_error *error);

/** Its node-ID in force. */
uint32_t lx_can_node_id(const struct lx_can_node *self);

/** Its bit rate in force. */
uint64_t lx_can_node_kbaud(const struct lx_can_node *self);

/** Say so when two services of the node have come to share a CAN-ID. */
void lx_can_tell_shared(struct lx_can_node *self);

#endif
