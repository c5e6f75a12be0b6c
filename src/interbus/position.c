/* SPDX-License-Identifier: MIT */
/*
 * From the shaft to counts: direction, scale, offset and shift (I6, I8), speed and validity.
 *
 *   raw         0 .. steps * turns - 1 of the discs
 *   scaled      floor(raw * S / (U * steps)), modulo the range R = floor(S * turns / U)
 *   position    (scaled + offset + shift) modulo R
 */
#include "drehgeber/angle.h"
#include "interbus_private.h"

/* Fastest change of the LSB with a valid code word (6.1): 800 kHz, in steps a turn * 0.001 rpm. */
#define FASTEST ((int64_t)800000 * 60000)

/* I9 */
static uint32_t effective(const struct dg_ib_model *model, uint32_t steps)
{
    return steps + (model->steps_minus_one ? 1u : 0u);
}

bool ib_fits(const struct dg_ib_model *model, uint32_t steps, uint32_t revolutions)
{
    return steps > 0 && revolutions > 0 && revolutions <= model->turns &&
           effective(model, steps) <= revolutions * model->steps;
}

uint32_t ib_range_of(const struct dg_ib_model *model, uint32_t steps, uint32_t revolutions)
{
    return (uint32_t)((uint64_t)effective(model, steps) * model->turns / revolutions);
}

uint32_t dg_ib_range(const struct dg_ib *self)
{
    const struct dg_ib_model *model = self->setup.model;

    if (model->profile != DG_IB_K3) {
        return (uint32_t)model->steps * model->turns;
    }
    return ib_range_of(model, self->steps, self->revolutions);
}

static uint32_t scaled(const struct dg_ib *self, dg_ns now)
{
    const struct dg_ib_model *model = self->setup.model;
    uint32_t counts = (uint32_t)model->steps * model->turns;
    int64_t angle_counts = dg_angle_counts(dg_world_angle(self->setup.world, now), model->steps);
    uint32_t raw = (uint32_t)dg_mod(angle_counts, counts);

    if (model->profile != DG_IB_K3) {
        return raw;
    }
    if (self->direction == IB_COUNTERCLOCKWISE) {
        raw = counts - raw; /* all counts are R steps, which are 0 again */
    }
    /* Where R is not a whole number the last fraction of a step wraps to 0. */
    uint32_t divisor = self->revolutions * model->steps;
    uint64_t steps = (uint64_t)raw * effective(model, self->steps);
    return (uint32_t)(steps / divisor) % dg_ib_range(self);
}

uint32_t dg_ib_position(const struct dg_ib *self, dg_ns now)
{
    return (scaled(self, now) + self->offset + self->shift) % dg_ib_range(self);
}

uint32_t ib_preset_offset(const struct dg_ib *self, dg_ns now)
{
    uint32_t range = dg_ib_range(self);
    uint32_t without = (scaled(self, now) + self->shift) % range;

    return (self->preset % range + range - without) % range;
}

bool ib_invalid(const struct dg_ib *self, dg_ns now)
{
    const struct dg_world *world = self->setup.world;
    const struct dg_ib_model *model = self->setup.model;
    int64_t lsb = (int64_t)dg_world_speed_mrpm(world, now) * model->steps;
    bool multiturn_ok =
        world->multiturn_amplitude_ok && world->multiturn_sync_ok && world->multiturn_vector_ok;

    return now < self->ready_at || lsb > FASTEST || lsb < -FASTEST || !world->singleturn_ok ||
           (model->turns > 1 && !multiturn_ok);
}

uint32_t ib_speed(const struct dg_ib *self, dg_ns now)
{
    int64_t mrpm = dg_world_speed_mrpm(self->setup.world, now);

    /* To the nearest: the speed itself may be 0.001 rpm too small. */
    int64_t rpm = (mrpm + (mrpm < 0 ? -500 : 500)) / 1000;
    rpm = self->direction == IB_COUNTERCLOCKWISE ? -rpm : rpm;
    return (uint32_t)rpm & DG_IB_DATA_MASK;
}
