/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What all media share, and what each of them does.
 *
 *   | struct dg_bus | the medium's wire | place 0 | place 1 | ...
 */
#ifndef DREHGEBER_BUS_PRIVATE_H
#define DREHGEBER_BUS_PRIVATE_H

#include "drehgeber/bus.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"

/** An encoder on a bus. The medium's own part stands behind it. */
struct bus_place {
    struct dg_bus *bus;
    struct dg_host *host;
    struct dg_encoder *control; /**< NULL: no fault happens to it */
    size_t index;
    dg_ns deadline; /**< of the encoder */
};

struct bus_tape; /* bus_tape.h */

/** A medium. Operations may be NULL where they say so. */
struct dg_bus_medium {
    enum dg_medium medium;
    size_t wire_size;     /**< of its own state, */
    size_t place_size;    /**< ... and for each encoder, struct bus_place at the beginning */
    size_t encoders_most; /**< on one wire */
    bool ordered;         /**< go_on() and take() themselves serve what is due in the order of time:
                               nobody needs to ask for each moment */
    bool is_read;         /**< the other end looks at what came in, and `tx` may be NULL */
    /** Zeroed memory becomes a wire. @return 0; DG_ERR_ARGUMENT: not with this setup */
    int (*begin)(struct dg_bus *self, const void *setup);
    /** An encoder comes to its place. @return 0; DG_ERR_ARGUMENT: not on this wire */
    int (*attach)(struct bus_place *place);
    /** An encoder says something, inside of a call for it. */
    void (*hear)(struct bus_place *from, const struct dg_host_event *event);
    /** The other end does something at self->now. */
    void (*take)(struct dg_bus *self, const struct dg_tap_event *event);
    /** What is due at `now`, of the wire and of its encoders. */
    void (*go_on)(struct dg_bus *self, dg_ns now);
    /** When something is due, on the wire or in an encoder. */
    dg_ns (*next)(const struct dg_bus *self);
    /** The same is about to come: what the encoder feels of its wire before it senses anything.
     * NULL: nothing. */
    void (*feel)(struct bus_place *place, dg_ns now);
    /** Power, world, settings or faults of an encoder have changed; it knows already. */
    void (*changed)(struct bus_place *place, dg_ns now);
    /** Replies that wait for its memory may go. NULL: what was kept back is asked for again. */
    void (*durable)(struct bus_place *place, dg_ns now);
    /** What of the wire and of a place is in a state goes by `tape` (bus_tape.h). */
    void (*pass_wire)(const struct dg_bus *self, struct bus_tape *tape);
    void (*pass_place)(struct bus_place *place, struct bus_tape *tape);
    /** A state was taken over, behind those of the handles: what follows from them. NULL: nothing
     * does. */
    void (*restored)(struct dg_bus *self);
    /** An encoder is about to leave its place: what of it is elsewhere on the wire goes, too. NULL:
     * all of it is in its place. */
    void (*detach)(struct bus_place *place);
    /** It has left; those behind it have moved up to place `from` and the next ones. NULL: nobody
     * is told by its place. */
    void (*moved)(struct dg_bus *self, size_t from);
};

struct dg_bus {
    const struct dg_bus_medium *medium;
    const struct dg_bus_ops *ops;
    void *ctx;
    dg_ns now;    /**< the latest moment that was served */
    dg_ns called; /**< the latest moment that the host has said */
    bool watched; /**< somebody looks */
    size_t count;
    size_t room;
    size_t stride; /**< from place to place */
    void *wire;    /**< the medium's own */
    uint8_t *places;
};

static inline struct bus_place *dg_bus_place_at(const struct dg_bus *self, size_t index)
{
    return (struct bus_place *)(void *)(self->places + index * self->stride);
}

/** What is due before `now` happens, and it is `now`: for what comes in by a medium's own calls. */
void dg_bus_run_until(struct dg_bus *self, dg_ns now);

/** Whether a fault of the wire is set at one of the encoders. */
static inline bool dg_bus_is_bent(const struct dg_bus *self)
{
    for (size_t i = 0; i < self->count; i++) {
        const struct dg_encoder *control = dg_bus_place_at(self, i)->control;
        if (control != NULL && control->faults.wire != 0) {
            return true;
        }
    }
    return false;
}

/** Tell who looks. */
static inline void dg_bus_tell(const struct dg_bus *self, const struct dg_tap_event *event)
{
    if (self->watched) {
        self->ops->tap(self->ctx, event);
    }
}

#endif
