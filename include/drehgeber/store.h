/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EEPROM of a device: named regions behind a journal.
 *
 * After a power cut at any write, a value whose put or commit returned 0 is there; any other is
 * old or new, never mixed. Several changes committed together appear together or not at all.
 * What the store cannot undo (bytes that changed by themselves) it reports per region: mounting
 * checks every checked region's sum, and the device answers with the start-up error its table
 * names. Nothing is ever silently replaced by defaults.
 *
 * Layout on the medium: header, copy of the header, journal, then the regions in table order, a
 * checked region followed by its CRC-16. A damaged header is repaired from its copy.
 *
 * Layouts only grow: a later release appends regions to the table of a device and leaves the
 * others, the id and the size of the journal as they are. So it takes over the memory of an earlier
 * one: old regions keep their values, new ones get their defaults. A memory of a later release is
 * foreign.
 *
 * A commit writes the journal (changes, then its length and CRC-32), syncs, applies the changes in
 * place, syncs, and clears the journal. Mounting completes a journal that is whole and drops one
 * that is not. No RAM copy of the memory is kept.
 */
#ifndef DREHGEBER_STORE_H
#define DREHGEBER_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/hal.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A checked region is at most this long. */
#define DG_STORE_CHECKED_MAX 128u
/** Regions a layout may have. */
#define DG_STORE_REGIONS_MAX 32u

/** How a region is protected. */
enum dg_store_check {
    DG_STORE_RAW,     /**< no sum of its own; any part may be staged */
    DG_STORE_CHECKED, /**< CRC-16 behind it, verified when mounted; staged as a whole */
};

/** One row of a device's EEPROM table. */
struct dg_store_region {
    const char *name;     /**< lower case, unique in the layout; for hosts and fault injection */
    uint16_t size;        /**< bytes, 1..DG_STORE_CHECKED_MAX when checked */
    uint8_t check;        /**< enum dg_store_check */
    uint8_t startup_code; /**< wire code of the start-up error its damage raises; 0: none */
    /** Delivery state: fills `size` bytes at `out`. NULL: all FFh. `ctx` is the format call's. */
    void (*defaults)(const void *ctx, uint8_t *out);
};

/** A device's EEPROM. Const, shared by all devices of the kind. */
struct dg_store_layout {
    uint32_t id;           /**< names the device kind; kept in the header, the same for ever */
    uint16_t journal_size; /**< bytes for the changes of one commit: 6 + length for each; fixed */
    uint8_t region_count;  /**< 1..DG_STORE_REGIONS_MAX; new ones come last */
    const struct dg_store_region *regions;
};

/** A mounted EEPROM. Owned by the caller; plain data, no pointers into itself. */
struct dg_store {
    const struct dg_store_layout *layout;
    struct dg_nvm nvm;
    uint8_t region_count;    /**< of the memory; fewer than the layout's until it has grown */
    uint32_t damaged;        /**< bit n: region n failed its sum; cleared by a successful put */
    uint16_t journal_length; /**< bytes staged since begin */
    int8_t failed;           /**< why a stage since begin failed, or 0; commit will repeat it */
    bool unapplied;          /**< a committed journal could not be applied yet; retried first */
    uint32_t replays;        /**< journals completed while mounting */
    uint32_t repairs;        /**< headers repaired while mounting */
    uint32_t failures;       /**< calls that ended in DG_ERR_IO */
};

/** Bytes of memory the layout needs. */
DG_API uint32_t dg_store_size(const struct dg_store_layout *layout);

/** Address of region `region` in the memory (for fault injection and tools). */
DG_API uint32_t dg_store_address(const struct dg_store_layout *layout, uint8_t region);

/** Index of the region called `name`, or DG_ERR_ARGUMENT. */
DG_API int dg_store_find(const struct dg_store_layout *layout, const char *name);

/**
 * Write the delivery state: every region's defaults, then the headers last. A power cut leaves the
 * image that was there, or the new one, or an unfinished one, which is DG_ERR_BLANK for
 * dg_store_mount(); where there was none it may also leave DG_ERR_FOREIGN.
 * @return 0; DG_ERR_IO; DG_ERR_ARGUMENT when a region with defaults, or a checked one, is longer
 * than DG_STORE_CHECKED_MAX (the memory is erased by then)
 */
DG_API int dg_store_format(const struct dg_store_layout *layout, struct dg_nvm nvm,
                           const void *ctx);

/** Whether formatting it was begun and never ended, so that there is nothing in it to lose. */
DG_API bool dg_store_unfinished(const struct dg_store_layout *layout, struct dg_nvm nvm);

/**
 * Take over the memory: repair the header, complete or drop the journal, check every region
 * (see `damaged`). `self` needs no initialisation before.
 * @return 0 (also with damaged regions); DG_ERR_OLDER when the regions from `region_count` on are
 *         not there yet: the others can be read, and dg_store_grow() comes next; DG_ERR_BLANK;
 *         DG_ERR_FOREIGN when neither header is one of this layout, or of fewer of its regions;
 *         DG_ERR_IO
 */
DG_API int dg_store_mount(struct dg_store *self, const struct dg_store_layout *layout,
                          struct dg_nvm nvm);

/**
 * Give a memory that was mounted with DG_ERR_OLDER the regions it lacks, with their defaults; `ctx`
 * as for dg_store_format(). A power cut leaves the older image or the grown one.
 * @return 0: mounted; DG_ERR_IO: mount again before anything else; DG_ERR_ARGUMENT as
 *         dg_store_format()
 */
DG_API int dg_store_grow(struct dg_store *self, const void *ctx);

/** Whether `region` failed its check. */
DG_API bool dg_store_damaged(const struct dg_store *self, uint8_t region);

/**
 * Read part of a region.
 * @return 0; DG_ERR_ARGUMENT when offset + n leaves the region; DG_ERR_IO
 */
DG_API int dg_store_read(struct dg_store *self, uint8_t region, uint16_t offset, void *to,
                         uint16_t n);

/** Forget what was staged. */
DG_API void dg_store_begin(struct dg_store *self);

/**
 * Add a change to the open commit. A checked region is staged whole (offset 0, n = its size).
 * The bytes are in the journal when this returns; `from` is not kept.
 * @return 0; DG_ERR_ARGUMENT; DG_ERR_SPACE when the journal is full; DG_ERR_IO. After a failure
 *         commit refuses with the same until the next begin.
 */
DG_API int dg_store_stage(struct dg_store *self, uint8_t region, uint16_t offset, const void *from,
                          uint16_t n);

/**
 * Make everything staged since begin durable, all or nothing.
 * @return 0: it is durable. DG_ERR_IO: it may or may not be; the next call settles it.
 */
DG_API int dg_store_commit(struct dg_store *self);

/** begin, stage, commit of one change. */
DG_API int dg_store_put(struct dg_store *self, uint8_t region, uint16_t offset, const void *from,
                        uint16_t n);

#ifdef __cplusplus
}
#endif

#endif
