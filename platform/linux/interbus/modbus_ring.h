/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A ring of INTERBUS encoders with their memories, and the master that drives it. What happens in a
 * cycle is the ring's (bus_words.h), when there is one the master's (ring_master.h).
 */
#ifndef DREHGEBER_LINUX_MODBUS_RING_H
#define DREHGEBER_LINUX_MODBUS_RING_H

#include "bus.h"
#include "drehgeber/interbus.h"
#include "drehgeber/ring_master.h"
#include "stacks.h"

/** Words of either image at most. */
#define LX_RING_WORDS_MAX ((size_t)DG_RING_WORDS_MAX * DG_RING_MAX)

/** What a ring is made of. What is pointed to must outlive it. */
struct lx_ring_setup {
    const struct lx_bus_setup *bus; /**< its devices, in ring order */
    struct dg_bus *core;            /**< the library's */
    const struct lx_tap *tap;       /**< who looks at the wire */
    dg_ns cycle;                    /**< dg_ring_master_setup.period */
    /** As in lx_image_setup: IN words may be held back no longer, from the next cycle on. */
    void (*settled)(void *ctx, dg_ns now);
    void *ctx;
};

/** A memory of one device or several. */
struct lx_ring_store {
    const char *path;            /**< NULL: no file */
    struct lx_image_part *parts; /**< of those devices, in ring order */
    size_t count;
    struct lx_image image;
};

/** A ring. Not to be moved. */
struct lx_ring {
    const struct lx_bus_setup *setup;
    struct lx_image_part **part_of; /**< of each device, its part of a memory; owned */
    struct lx_image_part *parts;    /**< in the order of the stores; owned */
    struct lx_ring_store *stores;   /**< as many as store_count; owned */
    size_t store_count;
    size_t count;        /**< devices, 1..DG_RING_MAX */
    const char *refused; /**< the file an error of lx_ring_open() is about; NULL: none */
    const struct lx_tap *tap;
    struct dg_bus *bus;
    const struct dg_ring_state *is;
    struct dg_ring_master master;
    uint16_t out[LX_RING_WORDS_MAX];
};

/** The door of its bus: `ctx` is the ring, whose memory is all zero until it is opened. */
extern const struct dg_bus_ops lx_ring_ops;

/** Switch everything on at `now`. @return 0, or -1 with one line in `error`, then close */
int lx_ring_open(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                 struct lx_error *error);

/** Switch everything off; also after a failed open, or when all is zero. */
void lx_ring_close(struct lx_ring *self);

#endif
