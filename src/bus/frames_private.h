/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A bus of frames from inside.
 *
 *   | struct dg_bus | struct frames_wire | struct frames_place | struct frames_place | ...
 */
#ifndef DREHGEBER_BUS_FRAMES_PRIVATE_H
#define DREHGEBER_BUS_FRAMES_PRIVATE_H

#include "bus_private.h"
#include "drehgeber/bus_frames.h"

#define FRAMES_IDS 0x800u

/** Frames that wait, oldest first: places in frames_wire.room, from 1; 0: none. */
struct frames_list {
    uint16_t first;
    uint16_t last;
    uint16_t count;
};

/** One identifier of an encoder; those of all with the same one are a list. */
struct frames_filter {
    uint16_t id;
    uint16_t next; /**< DG_HOST_FILTERS * place + filter + 1; 0: none */
};

/** Encoders. */
struct frames_set {
    uint32_t word[(DG_BUS_FRAMES_ENCODERS + 31u) / 32u]; /**< bit n of word m: place 32m + n */
};

/** An encoder on the bus. */
struct frames_place {
    struct bus_place base;                /**< its deadline is here: */
    dg_ns due;                            /**< as dg_host_next() said */
    dg_ns last_held;                      /**< when the last frame that is late goes out */
    const struct dg_host_controller *ask; /**< what it tells of itself: */
    const void *device;
    uint32_t version; /**< of the answers, when they were asked for */
    uint32_t bit_rate;
    struct frames_list answers; /**< that wait for its memory */
    uint16_t held;              /**< frames of it that are late */
    bool hears;                 /**< the wire has its bit rate */
    uint8_t filters;
    struct frames_filter filter[DG_HOST_FILTERS];
};

/** The wire. */
struct frames_wire {
    struct dg_bus_frames_setup setup; /**< with the line of today */
    dg_ns soonest;                    /**< the earliest deadline of the encoders */
    dg_ns release;                    /**< when a frame that is late goes out */
    dg_ns busy_until;                 /**< the frame that was sent last is on the wire until then */
    uint64_t bits;
    struct dg_bus_frames_counters counters;
    uint32_t bit_rate;         /**< dg_bus_frames_bit_rate() */
    struct frames_list unused; /**< room for frames, behind those that were never used: */
    uint16_t used;
    struct frames_list heard;    /**< sent by an encoder, and another one listens to it */
    struct frames_list held;     /**< late by a fault */
    struct frames_list sending;  /**< their turn comes */
    enum dg_controller state;    /**< of the controller by itself */
    bool stalled;                /**< the port has no room */
    bool full;                   /**< too much waits for its time */
    bool passed;                 /**< `soonest` is of nobody any more */
    bool retuned;                /**< somebody's bit rate is another one */
    bool unsure;                 /**< encoders may not know whether there is a bus */
    bool refiltered;             /**< the host does not know yet */
    uint16_t head[FRAMES_IDS];   /**< of the lists of filters, by identifier */
    uint16_t listed;             /**< 1 + the identifier that was asked for last; 0: none */
    struct frames_set listeners; /**< of that one */
};

static inline struct frames_wire *dg_bus_frames_wire(const struct dg_bus *self)
{
    return self->wire;
}

static inline struct frames_place *dg_bus_frames_at(const struct dg_bus *self, size_t index)
{
    return (struct frames_place *)(void *)dg_bus_place_at(self, index);
}

/* --- frames.c --- */

/** The encoder learns whether somebody acknowledges, if that is news to it. */
void dg_bus_frames_tell_presence(struct frames_place *place);

/* --- frames_state.c: states, as struct dg_bus_medium has them --- */

void dg_bus_frames_pass_wire(const struct dg_bus *self, struct bus_tape *tape);
void dg_bus_frames_pass_place(struct bus_place *base, struct bus_tape *tape);
void dg_bus_frames_restored(struct dg_bus *self);

/* --- frames_leave.c: an encoder leaves, as struct dg_bus_medium has it --- */

void dg_bus_frames_detach(struct bus_place *base);
void dg_bus_frames_moved(struct dg_bus *self, size_t from);

/* --- frames_room.c --- */

/** A frame of the encoder at `from` behind those in `list`. @return false: lost, and counted */
bool dg_bus_room_add(struct frames_wire *self, struct frames_list *list, size_t from, dg_ns at,
                     const struct dg_can_frame *frame);
/** The oldest one leaves `list`, which is not empty; a copy. */
struct dg_bus_frames_room dg_bus_room_fetch(struct frames_wire *self, struct frames_list *list);
/** The one that goes first by arbitration leaves it, likewise. */
struct dg_bus_frames_room dg_bus_room_arbitrate(struct frames_wire *self, struct frames_list *list);

/** Lists were changed: when a late frame goes out, and whether too much waits for its time. */
void dg_bus_room_settle(struct frames_wire *self);

/* --- frames_filter.c: who listens to what --- */

/** It listens to what it says, or, deaf, to nothing. */
void dg_bus_filter_list(struct frames_wire *self, struct frames_place *place);
/** All of them listen to what they say, whatever they did before. */
void dg_bus_filter_list_all(struct dg_bus *self);
/** Who listens to `id`. */
struct frames_set dg_bus_filter_of(const struct dg_bus *self, uint16_t id);
/** The host is told of what is new. */
void dg_bus_filter_tell(const struct dg_bus *self);

/* --- frames_line.c: bit rates, whether there is a bus --- */

/** What the encoder tells of itself has changed. */
void dg_bus_line_follow(struct frames_place *place, uint32_t version);
/** Who hears the wire. */
void dg_bus_line_tune(struct dg_bus *self);
/** Whether the encoder has a bus: a wire at its bit rate, with somebody on it. */
bool dg_bus_line_has_bus(const struct frames_wire *self, const struct frames_place *place);

#endif
