/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the files of this folder share.
 */
#ifndef SSI_PRIVATE_H
#define SSI_PRIVATE_H

#include "drehgeber/ssi.h"

/** line.c: every figure of the model is in range. */
bool dg_ssi_model_ok(const struct dg_ssi_model *model);

/** sense.c: store the position at `now`, and the word made of it. */
void dg_ssi_latch(struct dg_ssi *self, dg_ns now);

/** frame.c: the word of what was stored, of a model without a form. @return its bits */
uint8_t dg_ssi_make_word(const struct dg_ssi *self, uint8_t errors, uint64_t *word);

/** form.c: what makes words of other forms. The layout is the caller's to fill in. */
extern const struct dg_ssi_form dg_ssi_any_form;
/** form.c: count the bits of `form`, which is that of `model`, if it fits. @return NULL, or what
 * would be right, in words */
const char *dg_ssi_form_settle(const struct dg_ssi_model *model, struct dg_ssi_form *form);

/** Turns and position in the turn, in bits. */
static inline uint8_t ssi_position_bits(const struct dg_ssi_model *model)
{
    return (uint8_t)(model->multiturn_bits + model->singleturn_bits);
}

#endif
