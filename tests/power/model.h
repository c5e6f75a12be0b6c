/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a store may show after its power was cut, and the search through all that it can show.
 *
 * A version is the content of all regions after some of the changes. At every moment a set of
 * versions is acceptable: the one that was acknowledged, and those of a change under way. Each
 * image a power cut may leave is mounted, with the power cut again in every way while it recovers;
 * the version it then shows has to be acceptable, and is the only acceptable one from then on.
 */
#ifndef TESTS_POWER_MODEL_H
#define TESTS_POWER_MODEL_H

#include "drehgeber/store.h"
#include "lossy_nvm.h"

#define MODEL_VERSIONS 60u
#define MODEL_PARTS DG_STORE_REGIONS_MAX
/** Acceptable, beside versions: an image that says it is none. */
#define MODEL_REFUSED ((uint64_t)1 << 63)

/** One commit: bytes that follow from `seed` into parts of some regions. */
struct model_change {
    uint8_t seed;
    uint8_t count;
    struct {
        uint8_t region;
        uint16_t offset, n;
    } part[MODEL_PARTS];
};

/** Which operation of the store has lost one of its syncs, for a search that must not end well. */
enum model_operation { MODEL_COMMIT, MODEL_MOUNT, MODEL_GROW, MODEL_FORMAT };

struct model_version {
    uint8_t regions; /**< of an older release's image: fewer than the layout's */
    uint8_t bytes[LOSSY_NVM_MAX];
};

struct model {
    const char *name;
    const struct dg_store_layout *layout;
    const void *ctx;                  /**< of its delivery state, */
    uint8_t delivered[LOSSY_NVM_MAX]; /**< which is this */
    uint64_t limit;                   /**< images for each moment of a change */
    uint64_t recovery_limit;          /**< images for each moment of a recovery */
    uint32_t cuts;               /**< one after the other: the first, one in its recovery, ... */
    uint32_t again_every;        /**< after so many recoveries the change is tried again */
    enum model_operation broken; /**< this one does without its sync number `skip` */
    uint32_t skip;
    uint32_t version_count;
    struct model_version version[MODEL_VERSIONS];
    uint64_t states, recovery_states, images, moments, whole_moments; /**< looked at so far */
    uint64_t violations;
    char first[160]; /**< what the first one is */
    uint64_t *seen;  /**< owned; hashes of images that were mounted, open addressing */
    size_t seen_size, seen_count;
};

/** Where something happens: a memory, what it may show, how often the power was cut before. */
struct model_run {
    struct model *model;
    struct lossy_nvm *nvm;
    uint64_t acceptable;
    uint32_t depth;
    const struct model_change *again; /**< tried again after each recovery; may be NULL */
};

/** `ctx` as for dg_store_format(); `limit` and a tenth of it are the two limits.
    @return of dg_store_format() */
int model_init(struct model *self, const char *name, const struct dg_store_layout *layout,
               const void *ctx, uint64_t limit);
void model_free(struct model *self);

/** Forget versions and images: the memory holds `image` of `regions` regions; its version. */
uint64_t model_start(struct model *self, const uint8_t *image, uint8_t regions);

/** The acceptable versions with `change` made to each. */
uint64_t model_with(struct model *self, uint64_t versions, const struct model_change *change);

/** Look at every image of this moment. */
void model_look(struct model_run *run);

/** Take a memory over as a device does when it starts. @return of dg_store_mount(), _grow() */
int model_take_over(struct model_run *run, struct dg_store *store);

/** Begin a commit and stage all of `change`. @return of dg_store_stage() */
int model_stage(struct dg_store *store, const struct model_change *change);

/** Make a change, looking at every moment. @return what the store did */
int model_commit(struct model_run *run, struct dg_store *store, const struct model_change *change);

/** Read something; what the memory shows then, it has to go on showing. @return what it did */
int model_read(struct model_run *run, struct dg_store *store);

/** Write the delivery state over what was acceptable, looking at every moment. @return as above */
int model_format(struct model_run *run);

#endif
