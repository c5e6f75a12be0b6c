/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A protocol's side of models that are texts: which figures a text may change in a copy of a
 * built-in model, or how a model is made of a file of another kind. One const object in a file of
 * its own in the protocol's folder (model.c), linked by whoever reads such texts: an image whose
 * models are all built in carries none of it.
 */
#ifndef DREHGEBER_MODEL_H
#define DREHGEBER_MODEL_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_model_memory; /* stamp.h */

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
    const struct dg_model_memory *memory; /**< what the EEPROM of a model goes by; NULL: none has
                                               one */
};

/** The figure called `name`; NULL: there is none, or it is one of a single encoder. */
DG_API const struct dg_key *dg_model_figure(const struct dg_model_text *self, const char *name);

/** Figure `index` of all; NULL behind the last one. */
DG_API const struct dg_key *dg_model_figure_at(const struct dg_model_text *self, size_t index);

/* ---------------------------------------------------------------- files that are models */

/** The text of a file that is a model. */
struct dg_model_source {
    const char *text; /**< any bytes, no zero behind them is needed */
    size_t n;
    void *memory; /**< for what is made of it, as long as the model is used; aligned for any type */
    size_t memory_size;
};

/** What was made of it. */
struct dg_model_made {
    const struct dg_device *device; /**< in the memory */
    size_t used;     /**< bytes of the memory, from its beginning; the rest is free again */
    unsigned lacks;  /**< what the text promises and the encoder does not do */
    uint8_t address; /**< of encoders that nobody has given one; 0: as of all of the protocol */
};

/** What is wrong with it; each is one printable line. */
struct dg_model_flaw {
    unsigned line; /**< 0: none in particular */
    char what[256];
    char right[128]; /**< what would be right; "": `what` says it */
};

/** A protocol whose models can be files of their own, such as EDS files. */
struct dg_model_file {
    const char *const *endings; /**< of their names, case aside: ".eds"; NULL behind the last */
    /** Make a model of a text. It opens nothing, and no text makes it need more time or memory than
     * its length allows. @return 0; DG_ERR_SPACE: more memory is needed; DG_ERR_ARGUMENT with
     * `flaw` */
    int (*read)(const struct dg_model_source *from, struct dg_model_made *to,
                struct dg_model_flaw *flaw);
};

#ifdef __cplusplus
}
#endif

#endif
