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

    const uint32_t around = model->form == NULL ? error_bits + parity_bits : model->form->around;

    return (uint8_t)(ssi_position_bits(model) + around);
}

/* Whether an odd number of bits is set. The lowest bit of a number taken for Gray code is the
 * parity of all its bits. */
static uint32_t odd(uint64_t bits)
{
    return dg_ssi_binary((uint32_t)(bits ^ bits >> 32)) & 1u;
}

uint8_t dg_ssi_make_word(const struct dg_ssi *self, uint8_t errors, uint64_t *word)
{
    const struct dg_ssi_model *model = self->setup.model;
    const uint32_t position = (uint32_t)self->position;
    const bool error = errors != 0;
    uint64_t bits = model->code == DG_SSI_GRAY ? dg_ssi_gray(position) : position;
    uint32_t count = ssi_position_bits(model);

    if (model->error_bit != DG_SSI_ERROR_NONE) {
        bits = bits << 1 | (error == (model->error_bit == DG_SSI_ERROR_HIGH) ? 1u : 0u);
        count++;
    }
    if (model->parity != DG_SSI_PARITY_NONE) {
        bits = bits << 1 | (odd(bits) ^ (model->parity == DG_SSI_PARITY_ODD ? 1u : 0u));
        count++;
    }
    *word = bits;
    return (uint8_t)count;
}

int dg_ssi_frame_decode(const struct dg_ssi_model *model, uint64_t bits, struct dg_ssi_frame *frame)
{
    if (model->form != NULL) {
        return model->form->take_apart(model, bits, frame);
    }
    const uint64_t word = bits & (((uint64_t)1 << dg_ssi_word_bits(model)) - 1u);
    const uint32_t st_bits = model->singleturn_bits;
    uint64_t rest = word;

    rest = model->parity == DG_SSI_PARITY_NONE ? rest : rest >> 1;
    frame->error = model->error_bit != DG_SSI_ERROR_NONE &&
                   ((rest & 1u) != 0) == (model->error_bit == DG_SSI_ERROR_HIGH);
    rest = model->error_bit == DG_SSI_ERROR_NONE ? rest : rest >> 1;

    const uint32_t position =
        model->code == DG_SSI_GRAY ? dg_ssi_binary((uint32_t)rest) : (uint32_t)rest;
    frame->position = position;
    /* Both shifts fit: a turn has at most 31 bits. */
    frame->multiturn = position >> st_bits;
    frame->singleturn = position & (((uint32_t)1 << st_bits) - 1u);
    frame->toggle = false;
    frame->power_fail = false;
    /* All other bits are some position, and some error bit. */
    return model->parity == DG_SSI_PARITY_NONE ||
                   odd(word) == (model->parity == DG_SSI_PARITY_ODD ? 1u : 0u)
               ? DG_OK
               : DG_ERR_DAMAGED;
}
