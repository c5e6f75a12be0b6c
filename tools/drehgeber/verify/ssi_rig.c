/* SPDX-License-Identifier: MIT */
#include "ssi_rig.h"

static dg_angle angle(void *ctx, dg_ns now)
{
    const struct ssi_rig *self = ctx;

    return (dg_angle)((uint64_t)self->angle + (uint64_t)self->angle_per_us * (now / 1000u));
}

int ssi_rig_init(struct ssi_rig *self, const struct dg_ssi_model *model)
{
    *self = (struct ssi_rig){.model = *model, .low_ns = 500, .high_ns = 500, .now = DG_MS(1)};
    dg_world_init(&self->world);
    self->world.angle = angle;
    self->world.angle_ctx = self;
    return dg_ssi_init(&self->device, &(struct dg_ssi_setup){&self->model, &self->world});
}

void ssi_rig_power_on(struct ssi_rig *self)
{
    dg_ssi_power_on(&self->device, self->now);
    (void)ssi_rig_wait(self, self->model.init + self->model.monoflop);
}

bool ssi_rig_wait(struct ssi_rig *self, dg_ns span)
{
    const dg_ns end = self->now + span;
    dg_ns due = dg_ssi_step(&self->device, self->now);

    while (due <= end) {
        self->now = due;
        due = dg_ssi_step(&self->device, due);
    }
    self->now = end;
    return dg_ssi_data(&self->device);
}

bool ssi_rig_edge(struct ssi_rig *self, bool level)
{
    (void)dg_ssi_step(&self->device, self->now);
    const bool before = dg_ssi_data(&self->device);
    const bool data = dg_ssi_clock(&self->device, self->now, level);

    self->strayed =
        self->strayed || data != dg_ssi_data(&self->device) || (!level && data != before);
    return data;
}

uint64_t ssi_rig_take(struct ssi_rig *self, unsigned n)
{
    uint64_t bits = 0;

    for (; n > 0; n--) {
        (void)ssi_rig_edge(self, false);
        (void)ssi_rig_wait(self, self->low_ns);
        (void)ssi_rig_edge(self, true);
        bits = bits << 1 | ssi_rig_wait(self, self->high_ns);
    }
    return bits;
}

unsigned ssi_rig_bits(const struct dg_ssi_model *model)
{
    unsigned bits = (unsigned)model->multiturn_bits + model->singleturn_bits;

    bits += model->error_bit != DG_SSI_ERROR_NONE ? 1u : 0u;
    return bits + (model->parity != DG_SSI_PARITY_NONE ? 1u : 0u);
}

/* Bit by bit, from the definition of the reflected code: a bit changes where the one above is 1. */
uint64_t ssi_rig_word(const struct dg_ssi_model *model, uint32_t position, bool error)
{
    unsigned ones = 0;
    unsigned above = 0;
    uint64_t word = 0;

    for (unsigned i = (unsigned)model->multiturn_bits + model->singleturn_bits; i-- > 0;) {
        const unsigned bit = position >> i & 1u;
        const unsigned sent = model->code == DG_SSI_GRAY && above != 0 ? 1u - bit : bit;
        word = word * 2u + sent;
        ones += sent;
        above = bit;
    }
    if (model->error_bit != DG_SSI_ERROR_NONE) {
        const unsigned sent = error == (model->error_bit == DG_SSI_ERROR_HIGH) ? 1 : 0;
        word = word * 2u + sent;
        ones += sent;
    }
    if (model->parity != DG_SSI_PARITY_NONE) {
        word = word * 2u + (ones + (model->parity == DG_SSI_PARITY_ODD ? 1u : 0u)) % 2u;
    }
    return word;
}
