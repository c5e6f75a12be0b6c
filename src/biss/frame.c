/* SPDX-License-Identifier: MIT */
/*
 * The layout of a frame behind CDS (5.2.1.2), most significant bit first:
 *
 *   MT, ST       nERR nWARN   LC           ~CRC6 over all in front of it
 *   0..32, 8..32  2           6 or none    6 bits
 */
#include "biss_private.h"

static uint64_t field(uint64_t bits, uint8_t low, uint8_t count)
{
    return bits >> low & (((uint64_t)1 << count) - 1u);
}

uint8_t dg_biss_position_bits(const struct dg_biss_model *model)
{
    return (uint8_t)(model->multiturn_bits + model->singleturn_bits + DG_BISS_FLAG_BITS);
}

uint8_t dg_biss_life_bits(const struct dg_biss_model *model)
{
    return model->life_counter ? DG_BISS_LIFE_BITS : 0u;
}

uint8_t dg_biss_frame_bits(const struct dg_biss_model *model)
{
    const uint8_t usual =
        (uint8_t)(DG_BISS_FLAG_BITS + dg_biss_life_bits(model) + DG_BISS_CRC_BITS);
    const uint8_t around = model->form == NULL ? usual : model->form->around;

    return (uint8_t)(model->multiturn_bits + model->singleturn_bits + around);
}

uint8_t dg_biss_frame_encode(const struct dg_biss *self, uint8_t flags, uint64_t *bits)
{
    const struct dg_biss_model *model = self->setup.model;

    if (model->form != NULL) {
        return model->form->make_frame(self, flags, bits);
    }
    uint64_t data = self->position << DG_BISS_FLAG_BITS | flags;
    uint8_t n = dg_biss_position_bits(model);

    if (model->life_counter) {
        data = data << DG_BISS_LIFE_BITS | self->life;
        n = (uint8_t)(n + DG_BISS_LIFE_BITS);
    }
    *bits = data << DG_BISS_CRC_BITS | dg_biss_crc6(data, n);
    return (uint8_t)(n + DG_BISS_CRC_BITS);
}

void dg_biss_frame_decode(const struct dg_biss_model *model, uint64_t bits,
                          struct dg_biss_data *out)
{
    const uint8_t mt_bits = model->multiturn_bits;
    const uint8_t st_bits = model->singleturn_bits;

    if (model->form != NULL) {
        model->form->take_apart(model, bits, out);
        return;
    }
    const uint8_t life_bits = dg_biss_life_bits(model);
    const uint8_t flags = (uint8_t)(DG_BISS_CRC_BITS + life_bits);
    const uint8_t st = (uint8_t)(flags + DG_BISS_FLAG_BITS);
    const uint8_t checked = (uint8_t)(dg_biss_frame_bits(model) - DG_BISS_CRC_BITS);

    *out = (struct dg_biss_data){
        .position = field(bits, st, (uint8_t)(mt_bits + st_bits)),
        .multiturn = (uint32_t)field(bits, (uint8_t)(st + st_bits), mt_bits),
        .singleturn = (uint32_t)field(bits, st, st_bits),
        .life = (uint8_t)field(bits, DG_BISS_CRC_BITS, life_bits),
        .n_err = field(bits, (uint8_t)(flags + 1u), 1) != 0,
        .n_warn = field(bits, flags, 1) != 0,
        .crc_ok =
            field(bits, 0, DG_BISS_CRC_BITS) == dg_biss_crc6(bits >> DG_BISS_CRC_BITS, checked),
    };
}
