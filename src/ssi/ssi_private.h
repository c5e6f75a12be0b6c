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

/** frame.c: the word of a position, right-aligned. */
uint64_t dg_ssi_word(const struct dg_ssi_model *model, uint32_t position, bool error);

/** Turns and position in the turn, in bits. */
static inline uint8_t ssi_position_bits(const struct dg_ssi_model *model)
{
    return (uint8_t)(model->multiturn_bits + model->singleturn_bits);
}

#endif
