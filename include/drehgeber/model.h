/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A protocol's side of models that are texts: which figures a text may change in a copy of a
 * built-in model. One const object in a file of its own in the protocol's folder (model.c), linked
 * by whoever reads such texts: an image whose models are all built in carries none of it.
 */
#ifndef DREHGEBER_MODEL_H
#define DREHGEBER_MODEL_H

#include <stddef.h>

#include "drehgeber/api.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a text can say of a model. */
struct dg_model_text {
    const struct dg_stack *stack;
    const struct dg_keys
        *keys;       /**< settings of an encoder; those that lie in its model are figures */
    size_t own_size; /**< bytes of the stack's own kind of model */
    const struct dg_keys *more; /**< figures that no built-in model has; offsets count from the
                                     beginning of the model, too. NULL: there are none */
    size_t size; /**< bytes of a model that is a text; it begins with the stack's own */
    const char *const *heirlooms; /**< what of a base is not its frame nor its timing, a word each;
                                     a model has it only if its text says so. NULL behind the last;
                                       NULL: there is nothing of that kind */
    /** Take heirloom `index` out of `model`; NULL with `heirlooms`. */
    void (*drop)(void *model, size_t index);
    /** `to` becomes a copy of `from`, which is built in or was made so. NULL: `own_size` bytes are
     * all there is. */
    void (*copy)(void *to, const void *from);
    /** All figures of `model` are set, each in its range: put them into force, if they fit each
     * other. @return NULL, or what would be right, in words */
    const char *(*settle)(void *model);
};

/** The figure called `name`; NULL: there is none, or it is one of a single encoder. */
DG_API const struct dg_key *dg_model_figure(const struct dg_model_text *self, const char *name);

/** Figure `index` of all; NULL behind the last one. */
DG_API const struct dg_key *dg_model_figure_at(const struct dg_model_text *self, size_t index);

#ifdef __cplusplus
}
#endif

#endif
