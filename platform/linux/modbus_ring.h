/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A ring of INTERBUS encoders with its memory, and the master that drives it: one call, one cycle.
 */
#ifndef DREHGEBER_LINUX_MODBUS_RING_H
#define DREHGEBER_LINUX_MODBUS_RING_H

#include "drehgeber/interbus.h"
#include "modbus_settings.h"
#include "nvm_file.h"
#include "nvm_memory.h"

/** Words of either image at most: two for each device. */
#define LX_RING_WORDS_MAX (2u * DG_IB_RING_MAX)

/** What a ring is made of. Everything pointed to must outlive it. */
struct lx_ring_setup {
    const struct dg_ib_model *const *models; /**< in ring order */
    size_t count;                            /**< 1..DG_IB_RING_MAX */
    const struct lx_ring_settings *settings;
    const char *nvm; /**< file; NULL: state is lost at the end */
    const struct lx_say *say;
};

/** The part of the memory that belongs to one device. */
struct lx_ring_slice {
    struct dg_nvm whole;
    uint32_t base;
};

/** A ring. Not to be moved. */
struct lx_ring {
    struct dg_ib *devices; /**< owned, as the arrays below */
    struct dg_ib_model *models;
    struct lx_ring_slice *slices;
    struct lx_nvm_memory memory; /**< delivery state; the memory itself without a file */
    struct lx_nvm_file file;     /**< images of the devices with a memory, in ring order */
    struct dg_ib_ring ring;
    bool stopped; /**< ID cycles only */
    enum dg_ib_ring_result result;
    uint16_t reached; /**< by the last ID cycle */
    uint16_t ids[DG_IB_RING_MAX];
    uint16_t in[LX_RING_WORDS_MAX];
    uint16_t out[LX_RING_WORDS_MAX];
};

/** Switch everything on at `now`. @return 0, or -1 with one line in `error`, then close */
int lx_ring_open(struct lx_ring *self, const struct lx_ring_setup *setup, dg_ns now,
                 struct lx_error *error);

/** Switch everything off; also after a failed open. */
void lx_ring_close(struct lx_ring *self);

/** A data cycle with the images, or an ID cycle where one is called for. */
void lx_ring_cycle(struct lx_ring *self, dg_ns now);

#endif
