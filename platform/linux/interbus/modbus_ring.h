/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A ring of INTERBUS encoders with their memories, and the master that drives it: one call, one
 * cycle. What happens in one is the ring's (bus_words.h).
 */
#ifndef DREHGEBER_LINUX_MODBUS_RING_H
#define DREHGEBER_LINUX_MODBUS_RING_H

#include "drehgeber/bus_words.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/interbus.h"
#include "image.h"
#include "modbus_settings.h"
#include "tap.h"

/** Words of either image at most. */
#define LX_RING_WORDS_MAX ((size_t)DG_RING_WORDS_MAX * DG_RING_MAX)

/** A device, in ring order. */
struct lx_ring_member {
    const struct dg_device *device;
    struct dg_ib_model model;     /**< its figures as they were set */
    const struct dg_world *world; /**< what it senses to begin with; then lx_ring_world() is */
    struct dg_encoder *control;   /**< whose wire faults happen to it; NULL: none do */
    /** File of its EEPROM; NULL: state is lost at the end. Several devices may share one: it holds
     * the images of those with a memory in ring order. */
    const char *nvm;
};

/** What a ring is made of. What the members point to must outlive it. */
struct lx_ring_setup {
    const struct lx_ring_member *members;
    size_t count;             /**< 1..DG_RING_MAX */
    const struct lx_tap *tap; /**< who looks at the wire; NULL: nobody */
    const struct lx_say *say;
    struct lx_nvm_writer *writer; /**< of the files; NULL: they are written where they stand */
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
    struct dg_host **encoders;      /**< owned, as the arrays below; one for each device */
    struct lx_image_part **part_of; /**< its part of a memory */
    struct lx_image_part *parts;    /**< in the order of the stores */
    struct lx_ring_store *stores;   /**< as many as store_count */
    size_t store_count;
    size_t count;
    const char *refused; /**< the file an error of lx_ring_open() is about; NULL: none */
    const struct lx_tap *tap;
    struct dg_bus *bus; /**< owned */
    const struct dg_ring_state *is;
    bool stopped; /**< ID cycles only */
    uint16_t in[LX_RING_WORDS_MAX];
    uint16_t out[LX_RING_WORDS_MAX];
};

/** Switch everything on at `now`. @return 0, or -1 with one line in `error`, then close */
int lx_ring_open(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                 struct lx_error *error);

/** Switch everything off; also after a failed open, or when all is zero. */
void lx_ring_close(struct lx_ring *self);

/** The EEPROM of device `index`. */
struct dg_nvm lx_ring_nvm(const struct lx_ring *self, size_t index);

/** What stands in front of its file; NULL: it has none. Devices that share a file share it. */
const struct lx_nvm_queue *lx_ring_queue(const struct lx_ring *self, size_t index);

/** The device at a place, its figures, and what it senses. */
struct dg_ib *lx_ring_device(const struct lx_ring *self, size_t index);
const struct dg_ib_model *lx_ring_model(const struct lx_ring *self, size_t index);
struct dg_world *lx_ring_world(const struct lx_ring *self, size_t index);

/** A data cycle with the images, or an ID cycle where one is called for. @return false: a fault let
 * it not take place */
bool lx_ring_cycle(struct lx_ring *self, dg_ns now);

#endif
