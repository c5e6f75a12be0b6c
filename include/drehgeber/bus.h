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
 * are for one thread at a time.
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
 * @return its place, from 0; DG_ERR_ARGUMENT: it is of another medium, not for this wire, or made
 * by dg_host_init() without dg_host_take_side(); DG_ERR_SPACE
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

/**
 * Bytes of a state of the bus as it is now: what waits on the wire is in it, so that another moment
 * may need more.
 */
DG_API size_t dg_bus_state_size(const struct dg_bus *self);

/**
 * Save what is going on between the encoders; each of them has a state of its own (dg_host_save()),
 * and what goes on from all of them together is the same, byte for byte and nanosecond for
 * nanosecond:
 *
 *   in it       the moment; what is on the wire and on its way; replies, frames and words that wait
 *               for their time or for a memory; what faults do to what is on its way; the states of
 *               controllers, dg_bus_frames_set_line(), dg_ring_cut() and _spoil(), the IN image;
 *               what was counted
 *   not in it   setup, ops, encoders; which faults are at work and how often they still happen
 *               (dg_bus_attach()); what the port says of itself: dg_bus_watch(),
 *               dg_bus_frames_stall(), dg_bus_characters_set(), the tickets of its memories
 *
 * There is no pointer in it. What is due before the present has to be done (dg_bus_step()), and
 * changes of encoders be told (dg_bus_changed()).
 * @return enum dg_host_result: 0; DG_HOST_ERR_SPACE: `n` is less than its size; DG_HOST_ERR_STATE:
 * the bus is behind what the encoders wait for
 */
DG_API int dg_bus_save(const struct dg_bus *self, void *to, size_t n);

/**
 * Go on from a state that a bus of the same medium and the same build of the library has saved,
 * maybe in another process. It is made by dg_bus_init(), with as many encoders, attached in the
 * same order; their states are restored before. Setup, ops and faults stay those of this bus. No op
 * is called: a host asks dg_bus_next() and, of a bus of frames, dg_bus_frames_listens() anew. What
 * a state says is believed, whoever made it, but nothing that would lead out of memory or never
 * end.
 * @return enum dg_host_result: 0; nothing was changed: DG_HOST_ERR_SPACE: too short;
 * DG_HOST_ERR_OTHER: of another medium or build, or of fewer or more encoders;
 * DG_HOST_ERR_DAMAGED: its sum is wrong, or it does not go with the states of these encoders, the
 * words of this ring, the room for frames of this bus
 */
DG_API int dg_bus_restore(struct dg_bus *self, const void *from, size_t n);

/** Encoders on it. */
DG_API size_t dg_bus_count(const struct dg_bus *self);
/** The encoder at `place`, below dg_bus_count(). */
DG_API struct dg_host *dg_bus_encoder(const struct dg_bus *self, size_t place);
/** Its device, as its stack makes it; there once it was switched on. */
DG_API void *dg_bus_device(const struct dg_bus *self, size_t place);
/** What is set of it; it begins with the figures of its stack's model. */
DG_API const void *dg_bus_settings(const struct dg_bus *self, size_t place);

#ifdef __cplusplus
}
#endif

#endif
