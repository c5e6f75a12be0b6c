/* SPDX-License-Identifier: MIT */
/**
 * @file
 * EEPROMs of models that are texts. Behind the regions of its protocol each has a text: the figures
 * that the others go by, a line each. Its layout has an id of its own, made of them. So what an
 * encoder of other figures has stored is foreign to whoever mounts it, and here is who finds out
 * why, and what of it can be kept.
 *
 *   header | journal | regions of the protocol ... | protocol=biss\n st=26\n mt=0\n
 *
 * An image whose models are all built in links none of this.
 */
#ifndef DREHGEBER_STAMP_H
#define DREHGEBER_STAMP_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/hal.h"
#include "drehgeber/model.h"
#include "drehgeber/store.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Regions that the figures take, at most, and bytes of each. */
#define DG_MODEL_STAMP_PARTS 3u
#define DG_MODEL_STAMP_PART DG_STORE_CHECKED_MAX
/** Longest value of a figure, in characters. */
#define DG_MODEL_STAMP_VALUE_MAX 47u

/** Regions that go on in an EEPROM of other figures. */
struct dg_model_kept {
    uint8_t first;
    uint8_t last;
    const char *what;         /**< in them, in words; NULL: another row says it */
    const char *const *needs; /**< figures that have to be the same; NULL behind the last; NULL:
                                   none */
};

/** What the EEPROMs of a protocol's models depend on. */
struct dg_model_memory {
    size_t layout_at; /**< in a model: a const struct dg_store_layout *, which is NULL in those that
                           are built in */
    const char *const *figures; /**< that stored bytes go by; NULL behind the last */
    const struct dg_model_kept *kept;
    size_t kept_count;
    /** Delivery state of the regions that the figures take; `ctx` is the model.
     * DG_MODEL_STAMP_DEFAULTS() makes them. */
    void (*const *defaults)(const void *ctx, uint8_t *out);
};

/** The layout of a model, with its figures. Not to be moved: a model points to it. */
struct dg_model_stamp {
    struct dg_store_layout layout;
    const struct dg_store_layout *base; /**< of the protocol */
    const struct dg_model_memory *memory;
    struct dg_store_region regions[DG_STORE_REGIONS_MAX];
    char figures[DG_MODEL_STAMP_PARTS * DG_MODEL_STAMP_PART + 1u]; /**< KEY=VALUE, a line each */
};

/** A figure that an EEPROM does not have, or not like this. */
struct dg_model_misfit {
    const char *key;
    const char *found;    /**< in the EEPROM; NULL: it is not there */
    const char *expected; /**< of the model; NULL: it has none */
};

/** Give `model`, whose figures are settled, a layout in `to`. Nothing is done for a model without
 * an EEPROM. */
DG_API void dg_model_stamp_make(struct dg_model_stamp *to, const struct dg_model_text *text,
                                void *model);

/** That of a model; NULL: it is built in, or has no EEPROM. */
DG_API const struct dg_model_stamp *dg_model_stamp_of(const struct dg_model_text *text,
                                                      const void *model);

/** Part `part` of the figures that a layout in a struct dg_model_stamp has. */
DG_API void dg_model_stamp_part(const struct dg_store_layout *layout, size_t part, uint8_t *out);

/**
 * Whose figures an EEPROM has. It may be repaired, as by dg_store_mount(): give a copy.
 * @param tell is called for each figure that differs
 * @return 0: this model's; DG_ERR_ARGUMENT: another one's; DG_ERR_OLDER: it has no figures, as that
 *         of a built-in model; DG_ERR_FOREIGN: it is none of this protocol; DG_ERR_IO
 */
DG_API int dg_model_stamp_compare(const struct dg_model_stamp *self, struct dg_nvm nvm,
                                  void (*tell)(void *ctx, const struct dg_model_misfit *misfit),
                                  void *ctx);

/**
 * Copy what fits of `from` into `to`, which is as delivered.
 * @param tell is called for what stays as delivered, in words
 * @return 0; DG_ERR_FOREIGN: `from` is none of this protocol; DG_ERR_IO
 */
DG_API int dg_model_stamp_convert(const struct dg_model_stamp *self, struct dg_nvm from,
                                  struct dg_nvm to, void (*tell)(void *ctx, const char *what),
                                  void *ctx);

/** In a protocol's model.c: the delivery states of the regions, dg_model_memory.defaults, called
 * `name`. Its models are of `type`, which has the layout in its member `layout`. */
#define DG_MODEL_STAMP_DEFAULTS(name, type)                                                        \
    DG_MODEL_STAMP_DEFAULT(name, type, 0)                                                          \
    DG_MODEL_STAMP_DEFAULT(name, type, 1)                                                          \
    DG_MODEL_STAMP_DEFAULT(name, type, 2)                                                          \
    static void (*const name[DG_MODEL_STAMP_PARTS])(const void *ctx,                               \
                                                    uint8_t *out) = {name##_0, name##_1, name##_2}
#define DG_MODEL_STAMP_DEFAULT(name, type, part)                                                   \
    static void name##_##part(const void *ctx, uint8_t *out)                                       \
    {                                                                                              \
        dg_model_stamp_part(((const struct type *)ctx)->layout, part, out);                        \
    }

#ifdef __cplusplus
}
#endif

#endif
