/* SPDX-License-Identifier: MIT */
/**
 * @file
 * CANopen encoders on one bus of the event loop: any models, each with a world, a node-ID and an
 * EEPROM of its own. They hear the bus, and each other one turn of the loop later.
 */
#ifndef DREHGEBER_LINUX_CAN_BUS_H
#define DREHGEBER_LINUX_CAN_BUS_H

#include "bus.h"
#include "can.h"
#include "can_load.h"
#include "drehgeber/cia406.h"
#include "image.h"

/** Place in the net of a node that does not hear the wire. */
#define LX_CAN_DEAF UINT8_MAX

struct lx_can_bus;
struct lx_can_node;

/** A frame of a node that waits: for its turn with the other nodes, for its time, or for the disk.
 */
struct lx_can_waiting {
    struct lx_can_node *from;
    dg_ns at;
    uint64_t ticket; /**< of what it acknowledges */
    struct dg_can_frame frame;
};

/** Waiting frames, oldest first. */
struct lx_can_list {
    struct lx_can_waiting *frames; /**< owned */
    size_t count;
    size_t capacity;
};

/** Faults of the wire around a node: a layer between it and the bus. */
struct lx_can_layer {
    /** Put a frame on the wire, or what becomes of it. */
    void (*send)(struct lx_can_node *from, const struct dg_can_frame *frame);
    /** Whether a frame that comes in at `now` reaches the node. */
    bool (*reaches)(struct lx_can_node *node, dg_ns now);
    /** State of the node's controller, where that of the bus is `own`. */
    enum dg_co_bus_event (*state)(const struct lx_can_node *node, enum dg_co_bus_event own);
};

/** An encoder. */
struct lx_can_node {
    struct lx_can_bus *bus;
    struct lx_station *station;
    struct dg_cia406_device device;
    struct dg_cia406_model model; /**< with what the plan sets */
    struct lx_image image;        /**< its EEPROM: */
    struct lx_image_part memory;
    struct lx_can_list answers;      /**< to what is not on the disk yet */
    uint8_t id;                      /**< node-ID in the delivery state */
    uint16_t kbaud;                  /**< bit rate in force */
    bool hears;                      /**< the wire has this rate, too */
    uint8_t index;                   /**< in the bus's net; LX_CAN_DEAF: not there */
    const struct lx_can_layer *bent; /**< wire faults, or frames held back; NULL: neither */
    uint8_t shared_version;          /**< of its CAN-IDs, when they were last looked at */
    unsigned held;                   /**< frames held back */
    dg_ns last_held;                 /**< when the last one of them goes out */
    /** CAN-IDs that two of its services had at the last look; 0: none */
    uint16_t shared[DG_CO_SHARED_MAX];
};

/** A bus. */
struct lx_can_bus {
    struct lx_bus bus;
    lx_can_open *open;
    struct lx_can *can;
    bool pace;               /**< the plan wants it: frames take their time on the wire */
    struct lx_can_load load; /**< of the wire */
    struct lx_timer timer;
    struct dg_co_net net;                    /**< nodes that hear the wire */
    uint8_t filter_version[DG_CO_NET_NODES]; /**< of `net`, when the wire was told */
    bool told;                  /**< the wire knows who listens to what, but for filter_version */
    bool tapped;                /**< ... and that somebody wants to see all there is */
    dg_ns tapped_at;            /**< of the frame that the tap was told last */
    bool retuned;               /**< a node's bit rate has changed */
    bool bent;                  /**< some node is */
    enum dg_co_bus_event state; /**< of the controller: active, passive or off */
    dg_ns promised; /**< when the nodes want to be called next; a stalled bus serves nobody:
                       DG_NEVER */
    struct lx_can_list heard; /**< sent by a node, and another one listens to it */
    struct lx_can_list held;  /**< by the fault "delay" */
    struct lx_timer release;  /**< of held frames */
    struct lx_can_node *node; /**< owned, as many as stations */
};

/** A bus whose wire `open` opens. @return as lx_bus_make */
struct lx_bus *lx_can_bus_make(const struct lx_bus_setup *setup, lx_can_open *open,
                               struct lx_error *error);

/* --- a node, can_node.c --- */

/** Understand the plan of the station at `place`. @return 0, or -1 with one line in `error` */
int lx_can_node_make(struct lx_can_bus *bus, size_t place, struct lx_error *error);

/** Load its EEPROM, switch it on. `settled`: as in lx_image_setup, with the node as ctx.
 * @return 0, or -1 with one line in `error`, then close */
int lx_can_node_open(struct lx_can_node *self, const struct dg_co_ops *ops,
                     void (*settled)(void *ctx, dg_ns now), dg_ns now, struct lx_error *error);

/** Say so when two services of the node have come to share a CAN-ID. */
void lx_can_tell_shared(struct lx_can_node *self);

/** Switch it off, close its EEPROM; also after a failed open. */
void lx_can_node_close(struct lx_can_node *self);

/* --- answers that wait for the disk, can_answer.c --- */

/** Put a frame of a node on the wire, bent or not; an answer behind what the node writes to its
 * EEPROM file, when that is there. */
void lx_can_answer(struct lx_can_node *from, const struct dg_can_frame *frame);

/** Something of it is there, or lost: then what acknowledges it is, too. */
void lx_can_answer_settled(struct lx_can_node *from);

/** Without power nothing waits. */
void lx_can_answer_none(struct lx_can_node *from);

/* --- nodes and wire, can_wire.c --- */

/** Tell the tap of a frame, in the order of time: one that waited while another was answered is
 * told after the answer. */
void lx_can_tell(struct lx_can_bus *self, dg_ns at, bool ours, const struct dg_can_frame *frame);

/** Put a frame of a node on the wire: the tap, the wire itself, other nodes that listen. */
void lx_can_emit(struct lx_can_node *from, const struct dg_can_frame *frame);

/** The same, through the node's layer of faults if it has one. */
void lx_can_put(struct lx_can_node *from, const struct dg_can_frame *frame);

/** Append a frame. @return false without memory; then it is lost */
bool lx_can_list_append(struct lx_can_list *self, const struct lx_can_waiting *frame);

/** Offer a frame to the nodes that listen to it, but for `from` (NULL: it came over the wire). */
void lx_can_offer(struct lx_can_bus *self, dg_ns now, const struct dg_can_frame *frame,
                  const struct lx_can_node *from);

/** What the nodes have sent each other. */
void lx_can_hear(struct lx_can_bus *self, dg_ns now);

/** What the core has answered to a call that did not go through the net. */
void lx_can_note_deadline(struct lx_can_node *node, dg_ns deadline);

/** Tell the nodes whether there is a bus for them: a wire, at their bit rate, with somebody on it.
 * @return whether one did not know */
bool lx_can_tell_presence(struct lx_can_bus *self, dg_ns now);

/** Let the node's controller be in the bus's state, or in the worse one that a fault makes. */
void lx_can_follow(struct lx_can_node *self, dg_ns now);

/* --- faults of the wire, can_faults.c --- */

/** Faults or power of a node may have changed: whether it is bent, and its controller's state. */
void lx_can_bend(struct lx_can_node *self, dg_ns now);

/** Send held frames whose time has come. */
void lx_can_release(struct lx_can_bus *self, dg_ns now);

/** The protocol, as the port knows it. */
extern const struct lx_stack lx_can_stack;

/** The keys of the wire itself, of a bool: whether frames take their time. */
extern const struct lx_keys lx_can_keys;
extern const bool lx_can_pace;

#endif
