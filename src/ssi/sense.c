/* SPDX-License-Identifier: MIT */
/*
 * What the encoder senses: position, and what is wrong with it.
 */
#include "ssi_private.h"

uint64_t dg_ssi_position(const struct dg_ssi *self, dg_ns now)
{
    const struct dg_ssi_model *model = self->setup.model;

    if (model->form != NULL) {
        return model->form->find_position(self, now);
    }
    const dg_angle angle = dg_world_angle(self->setup.world, now);
    const int64_t counts = dg_angle_counts(angle, (uint32_t)1 << model->singleturn_bits);

    return (uint32_t)((uint64_t)counts & (((uint64_t)1 << ssi_position_bits(model)) - 1u));
}

static const struct dg_signal_limits limits = {
    .amplitude_min_permille = DG_SSI_AMPLITUDE_MIN_PERMILLE,
    .amplitude_max_permille = DG_SSI_AMPLITUDE_MAX_PERMILLE,
    .offset_max_permille = DG_SSI_OFFSET_MAX_PERMILLE,
};

static bool temperature_ok(int32_t mdegc)
{
    return mdegc >= DG_SSI_TEMPERATURE_MIN_MDEGC && mdegc <= DG_SSI_TEMPERATURE_MAX_MDEGC;
}

static bool multiturn_ok(const struct dg_ssi *self)
{
    const struct dg_world *world = self->setup.world;

    return self->setup.model->multiturn_bits == 0 ||
           (world->multiturn_amplitude_ok && world->multiturn_sync_ok &&
            world->multiturn_vector_ok);
}

uint8_t dg_ssi_errors(const struct dg_ssi *self)
{
    const struct dg_world *world = self->setup.world;
    uint32_t errors = 0;

    errors |= world->led_current_ua <= DG_SSI_LED_MAX_UA ? 0u : DG_SSI_LIGHT;
    errors |= dg_world_signals_ok(world, &limits) ? 0u : DG_SSI_SIGNAL;
    errors |= temperature_ok(world->temperature_mdegc) ? 0u : DG_SSI_TEMPERATURE;
    errors |= world->supply_mv >= DG_SSI_SUPPLY_MIN_MV ? 0u : DG_SSI_SUPPLY;
    errors |= world->singleturn_ok ? 0u : DG_SSI_SINGLETURN;
    errors |= multiturn_ok(self) ? 0u : DG_SSI_MULTITURN;
    errors |= world->watchdog_fired ? DG_SSI_SYSTEM : 0u;
    return (uint8_t)errors;
}

void dg_ssi_latch(struct dg_ssi *self, dg_ns now)
{
    const struct dg_ssi_form *form = self->setup.model->form;
    uint8_t (*const make_word)(const struct dg_ssi *, uint8_t, uint64_t *) =
        form == NULL ? dg_ssi_make_word : form->make_word;

    self->counters.frames++;
    self->position = dg_ssi_position(self, now);
    self->bits = make_word(self, dg_ssi_errors(self), &self->word);
    self->left = self->bits;
}
