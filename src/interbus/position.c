/* SPDX-License-Identifier: MIT */
/*
 * From the shaft to counts: direction, scale, offset and shift (I6, I8), and speed.
 *
 *   raw         0 .. steps * turns - 1 of the discs
 *   scaled      floor(raw * S / (U * steps)), modulo the range R = floor(S * turns / U)
 *   position    (scaled + offset + shift) modulo R
 */
#include "drehgeber/angle.h"
#include "drehgeber/wide.h"
#include "interbus_private.h"

/* I9 */
static uint32_t effective(const struct dg_ib_model *model, uint32_t steps)
{
    return steps + (model->steps_minus_one ? 1u : 0u);
}

bool dg_ib_fits(const struct dg_ib_model *model, uint32_t steps, uint32_t revolutions)
{
    return steps > 0 && revolutions > 0 && revolutions <= model->turns &&
           effective(model, steps) <= revolutions * model->steps;
}

uint32_t dg_ib_range_of(const struct dg_ib_model *model, uint32_t steps, uint32_t revolutions)
{
    return (uint32_t)((uint64_t)effective(model, steps) * model->turns / revolutions);
}

uint32_t dg_ib_range(const struct dg_ib *self)
{
    const struct dg_ib_model *model = self->setup.model;

    if (model->profile != DG_IB_K3) {
        return (uint32_t)model->steps * model->turns;
    }
    return dg_ib_range_of(model, self->steps, self->revolutions);
}

/* @param range R. @return 0 .. R - 1 */
static inline uint32_t scale_angle(const struct dg_ib *self, dg_angle angle, uint32_t *range)
{
    const struct dg_ib_model *model = self->setup.model;
    const uint32_t counts = (uint32_t)model->steps * model->turns;
    const int32_t turn = (int32_t)(uint32_t)((uint64_t)angle >> 32);
    const uint32_t step = (uint32_t)(dg_product((uint32_t)angle, model->steps) >> 32);
    uint32_t raw = (uint32_t)dg_mod(turn, model->turns) * model->steps + step;

    *range = counts;
    if (model->profile != DG_IB_K3) {
        return raw;
    }
    if (self->direction == IB_COUNTERCLOCKWISE && raw != 0) {
        raw = counts - raw;
    }
    const uint32_t divisor = self->revolutions * model->steps;
    const uint32_t steps = effective(model, self->steps);
    if (steps == divisor) {
        return raw;
    }
    /* Where R is not a whole number the last fraction of a step wraps to 0. */
    *range = dg_ib_range(self);
    return (uint32_t)((uint64_t)raw * steps / divisor) % *range;
}

uint32_t dg_ib_position_at(const struct dg_ib *self, dg_angle angle)
{
    uint32_t range;
    const uint32_t at = scale_angle(self, angle, &range);

    return (at + self->offset + self->shift) % range;
}

uint32_t dg_ib_position(const struct dg_ib *self, dg_ns now)
{
    return dg_ib_position_at(self, dg_world_angle(self->setup.world, now));
}

uint32_t dg_ib_preset_offset(const struct dg_ib *self, dg_ns now)
{
    uint32_t range;
    const uint32_t at = scale_angle(self, dg_world_angle(self->setup.world, now), &range);
    const uint32_t without = (at + self->shift) % range;

    return (self->preset % range + range - without) % range;
}

uint32_t dg_ib_speed(const struct dg_ib *self, int32_t mrpm)
{
    /* To the nearest: the speed itself may be 0.001 rpm too small. */
    int64_t rpm = ((int64_t)mrpm + (mrpm < 0 ? -500 : 500)) / 1000;
    rpm = self->direction == IB_COUNTERCLOCKWISE ? -rpm : rpm;
    return (uint32_t)rpm & DG_IB_DATA_MASK;
}
