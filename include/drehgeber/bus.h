/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A bus: a wire with the encoders on it, and all that happens between them. Who hears whom, what
 * becomes of two that send at once, how long something is on the wire, what its faults do, and
 * which reply waits for a slow memory is here and nowhere else. A host opens doors: what it reads
 * from a port goes in, what comes out it writes to the port.
 *
 *   struct dg_bus *bus = dg_bus_init(memory, dg_bus_size(&dg_bus_characters, 2), &setup);
 *   dg_bus_attach(bus, encoder, control), dg_bus_attach(bus, another, NULL)
 *   next = dg_bus_rx(bus, &event)     what the other end does
 *   next = dg_bus_step(bus, now)      time goes on
 *
 * The host owns memory and time. Nothing is allocated; nothing happens outside of these calls. What
 * the wire carries is told by `ops` inside of them, in the order of time; `ops` must not call back.
 * A moment before the latest one is taken for that one, and so is DG_NEVER, which is no moment:
 * many encoders have something to do for ever, and time does not go back. A bus and its encoders
 * are for one thread at a time. This header may change until 1.0.
 */
#ifndef DREHGEBER_BUS_H
#define DREHGEBER_BUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/tap.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_host;    /* an encoder: host.h */
struct dg_encoder; /* its faults: control.h */

/** A bus. Lives in the host's memory, at a multiple of DG_HOST_ALIGN. */
struct dg_bus;

/** What goes over a wire, whatever the protocol: an object each, in a file of its own, linked by
 * whoever names it. bus_characters.h and its like say what is special about one. */
struct dg_bus_medium;

/** What a reply that waits is to do, see dg_bus_ops.answer. */
enum dg_bus_answer {
    DG_BUS_SAY,  /**< what it acknowledges is durable */
    DG_BUS_KEEP, /**< not yet; dg_bus_durable() comes */
    DG_BUS_DROP, /**< it is lost: nobody acknowledges that */
};

/** The door. Operations may be NULL where they say so. */
struct dg_bus_ops {
    /** The wire carries `event` to the other end; event->ours is true. `place`: of its encoder.
     * NULL on a ring, whose other end reads its image. */
    void (*tx)(void *ctx, size_t place, const struct dg_tap_event *event);
    /** All that goes over the wire, in either direction. NULL: nobody looks. */
    void (*tap)(void *ctx, const struct dg_tap_event *event);
    /** Encoder `place` is about to acknowledge: is what its memory was handed before durable? NULL:
     * it always is. */
    enum dg_bus_answer (*answer)(void *ctx, size_t place);
    /** Rings: how often the memory of encoder `place` was handed something to keep so far. NULL: no
     * memory is slow. */
    uint64_t (*ticket)(void *ctx, size_t place);
};

/** What a bus is made of. Everything pointed to must outlive it. */
struct dg_bus_setup {
    size_t size;                        /**< sizeof(struct dg_bus_setup) */
    const struct dg_bus_medium *medium; /**< which also says what `wire` is */
    size_t encoders;                    /**< room for so many */
    const void *wire;                   /**< the medium's own setup, copied; NULL: as usual */
    const struct dg_bus_ops *ops;
    void *ctx;
};

/** Bytes of a bus with room for so many encoders; 0: the medium has none for as many. */
DG_API size_t dg_bus_size(const struct dg_bus_medium *medium, size_t encoders);

/** Make a bus without encoders at the moment 0. @return NULL: too small, not aligned, or `setup` is
 * not one of this version */
DG_API struct dg_bus *dg_bus_init(void *memory, size_t size, const struct dg_bus_setup *setup);

/**
 * Put an encoder on the bus, behind those that are on it: in a chain or a ring that is its place.
 * Its listener is the bus from now on. It has to outlive the bus, or leave it. What it should know
 * of the wire, e.g. the state of its controller, is told by dg_bus_changed().
 * @param control whose faults happen to what it sends and hears; NULL: none do
 * @return its place, from 0; DG_ERR_ARGUMENT: it is of another medium, or not for this wire;
 * DG_ERR_SPACE
 */
DG_API int dg_bus_attach(struct dg_bus *self, struct dg_host *encoder, struct dg_encoder *control);

/**
 * The plug of the encoder at `place`, below dg_bus_count(), is pulled at `now`, behind what was due
 * before. It hears nothing any more, and what it was sending ends:
 *
 *   characters  a reply ends in the middle of a character, which nobody hears; one that was told
 *               whole (dg_characters_setup.whole) is its door's to cut off
 *   frames      what waits for its turn, its time, a delay or the encoder's memory is lost; the
 *               encoder finds that nobody acknowledges
 *   edges       the chain closes: the data line is that of those who are left. Low: nobody is
 *   words       the ring closes, IN words move up; an ID cycle has to come first
 *
 * Those behind it move up: each place beyond `place` is less by one from now on, also in ops. The
 * handle has no listener then and no faults of this bus, keeps its power, and may go to any bus.
 * @return as dg_bus_step()
 */
DG_API dg_ns dg_bus_detach(struct dg_bus *self, size_t place, dg_ns now);

/** The faults of `control` happen to the encoder at `place` from now on; NULL: none do. For one
 * that got its control plane behind dg_bus_attach(). */
DG_API void dg_bus_control(struct dg_bus *self, size_t place, struct dg_encoder *control);

/** The other end does something: event->at is its moment, not before the latest one.
 * @return when to call again at the latest; DG_NEVER */
DG_API dg_ns dg_bus_rx(struct dg_bus *self, const struct dg_tap_event *event);

/** Do what is due up to `now`, each at its own moment. @return when to call again; DG_NEVER */
DG_API dg_ns dg_bus_step(struct dg_bus *self, dg_ns now);
/** The same moment; nothing happens. */
DG_API dg_ns dg_bus_next(const struct dg_bus *self);

/** It is `now`, and what was due before has happened: for who reads, or is about to change, what
 * the encoders are. */
DG_API void dg_bus_look(struct dg_bus *self, dg_ns now);

/** Power, world, settings or faults of an encoder have changed at `now`, behind dg_bus_look(): what
 * was due until then has met the old ones. @return as dg_bus_step() */
DG_API dg_ns dg_bus_changed(struct dg_bus *self, size_t place, dg_ns now);

/** What an encoder's memory was handed is durable, or lost: replies that waited for it may go.
 * @return as dg_bus_step() */
DG_API dg_ns dg_bus_durable(struct dg_bus *self, size_t place, dg_ns now);

/** Somebody looks at the wire as it goes, by ops->tap, or not any more: to begin with somebody does
 * if there is a tap. Without it the bus need not be called for what nobody sees. */
DG_API void dg_bus_watch(struct dg_bus *self, bool watched);

/** Encoders on it. */
DG_API size_t dg_bus_count(const struct dg_bus *self);
/** The encoder at `place`, below dg_bus_count(). */
DG_API struct dg_host *dg_bus_encoder(const struct dg_bus *self, size_t place);

#ifdef __cplusplus
}
#endif

#endif
