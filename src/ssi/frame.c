/* SPDX-License-Identifier: MIT */
/*
 * The word: position, error bit, parity bit, both ways.
 */
#include "ssi_private.h"

uint32_t dg_ssi_gray(uint32_t binary)
{
    return binary ^ binary >> 1;
}

uint32_t dg_ssi_binary(uint32_t gray)
{
    /* Each bit is the parity of all bits from it upwards: by doubling. */
    for (unsigned span = 1; span < 32; span *= 2) {
        gray ^= gray >> span;
    }
    return gray;
}

uint8_t dg_ssi_word_bits(const struct dg_ssi_model *model)
{
    const uint32_t error_bits = model->error_bit == DG_SSI_ERROR_NONE ? 0u : 1u;
    const uint32_t parity_bits = model->parity == DG_SSI_PARITY_NONE ? 0u : 1u;

    return (uint8_t)(ssi_position_bits(model) + error_bits + parity_bits);
}

/* Whether an odd number of bits is set. The lowest bit of a number taken for Gray code is the
 * parity of all its bits. */
static uint32_t odd(uint64_t bits)
{
    return dg_ssi_binary((uint32_t)(bits ^ bits >> 32)) & 1u;
}

uint64_t dg_ssi_word(const struct dg_ssi_model *model, uint32_t position, bool error)
{
    uint64_t word = model->code == DG_SSI_GRAY ? dg_ssi_gray(position) : position;

    if (model->error_bit != DG_SSI_ERROR_NONE) {
        word = word << 1 | (error == (model->error_bit == DG_SSI_ERROR_HIGH) ? 1u : 0u);
    }
    if (model->parity != DG_SSI_PARITY_NONE) {
        word = word << 1 | (odd(word) ^ (model->parity == DG_SSI_PARITY_ODD ? 1u : 0u));
    }
    return word;
}

int dg_ssi_frame_decode(const struct dg_ssi_model *model, uint64_t bits, struct dg_ssi_frame *frame)
{
    const uint64_t word = bits & (((uint64_t)1 << dg_ssi_word_bits(model)) - 1u);
    uint64_t rest = word;

    rest = model->parity == DG_SSI_PARITY_NONE ? rest : rest >> 1;
    frame->error = model->error_bit != DG_SSI_ERROR_NONE &&
                   ((rest & 1u) != 0) == (model->error_bit == DG_SSI_ERROR_HIGH);
    rest = model->error_bit == DG_SSI_ERROR_NONE ? rest : rest >> 1;

    frame->position = model->code == DG_SSI_GRAY ? dg_ssi_binary((uint32_t)rest) : (uint32_t)rest;
    /* Both shifts fit: a turn has at most 31 bits. */
    frame->multiturn = frame->position >> model->singleturn_bits;
    frame->singleturn = frame->position & (((uint32_t)1 << model->singleturn_bits) - 1u);
    /* Whatever it was made of, the word as it came would be made again. */
    return dg_ssi_word(model, frame->position, frame->error) == word ? DG_OK : DG_ERR_DAMAGED;
}
