/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A ring of INTERBUS encoders with their memories, and the master that drives it: one call, one
 * cycle.
 */
#ifndef DREHGEBER_LINUX_MODBUS_RING_H
#define DREHGEBER_LINUX_MODBUS_RING_H

#include "drehgeber/interbus.h"
#include "image.h"
#include "modbus_settings.h"

/** Words of either image at most: two for each device. */
#define LX_RING_WORDS_MAX (2u * DG_IB_RING_MAX)

/** A device, in ring order. */
struct lx_ring_member {
    struct dg_ib_model model;
    const struct dg_world *world;
    /** File of its EEPROM; NULL: state is lost at the end. Several devices may share one: it holds
     * the images of those with a memory in ring order. */
    const char *nvm;
};

/** What a ring is made of. What the members point to must outlive it. */
struct lx_ring_setup {
    const struct lx_ring_member *members;
    size_t count; /**< 1..DG_IB_RING_MAX */
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

/** Words of one device. */
#define LX_RING_OWN_WORDS_MAX 2u

/** What a device shows of its memory. Its answer to a command waits until what it acknowledges is
 * on the disk: meanwhile the master sees the IN words from before. */
struct lx_ring_window {
    struct lx_image_part *part;
    uint64_t settled; /**< ticket of the last sync of it that is known to be through, or lost */
    uint64_t looked;  /**< ... of the one that was there in the cycle before */
    bool holds;       /**< the master sees: */
    uint16_t shown[LX_RING_OWN_WORDS_MAX];
    uint16_t command[LX_RING_OWN_WORDS_MAX]; /**< the OUT words that it answers */
};

/** A ring. Not to be moved. */
struct lx_ring {
    struct dg_ib *devices; /**< owned, as the arrays below; one for each device */
    struct dg_ib_model *models;
    struct lx_ring_window *windows;
    struct lx_image_part *parts;  /**< in the order of the stores */
    struct lx_ring_store *stores; /**< as many as store_count */
    size_t store_count;
    const char *refused; /**< the file an error of lx_ring_open() is about; NULL: none */
    struct dg_ib_ring ring;
    bool stopped; /**< ID cycles only */
    enum dg_ib_ring_result result;
    uint16_t reached; /**< by the last ID cycle */
    uint16_t ids[DG_IB_RING_MAX];
    uint16_t in[LX_RING_WORDS_MAX];
    uint16_t out[LX_RING_WORDS_MAX];
    uint16_t before[LX_RING_WORDS_MAX]; /**< IN of the cycle before */
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

/** A data cycle with the images, or an ID cycle where one is called for. */
void lx_ring_cycle(struct lx_ring *self, dg_ns now);

/** After a cycle at `now`: until when further ones only count and latch, as long as nothing is done
 * to ring, images, devices and worlds; `now`: not even the next one. */
dg_ns lx_ring_quiet(const struct lx_ring *self, dg_ns now);

/** Count `n` such cycles, not the last of them. */
void lx_ring_skip(struct lx_ring *self, uint64_t n);

#endif
