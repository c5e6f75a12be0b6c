/* SPDX-License-Identifier: MIT */
/*
 * WORLd: what the selected encoder senses.
 */
#include "control_private.h"
#include "drehgeber/quantity.h"

/* How a unit is spoken: what numbers take, and the decimals of the answer. */
static const struct {
    uint8_t scpi; /* enum dg_scpi_unit */
    uint8_t places;
} units[] = {
    [DG_UNIT_MDEGC] = {DG_SCPI_TEMPERATURE, 3}, [DG_UNIT_UA] = {DG_SCPI_CURRENT, 0},
    [DG_UNIT_MV] = {DG_SCPI_VOLTAGE, 0},        [DG_UNIT_PERMILLE] = {DG_SCPI_PLAIN, 0},
    [DG_UNIT_STATE] = {DG_SCPI_PLAIN, 0},
};
_Static_assert(DG_COUNT(units) == DG_UNIT_COUNT, "a row for each unit");

struct dg_scpi_range dg_control_range(const struct dg_quantity *row)
{
    return (struct dg_scpi_range){
        .unit = (enum dg_scpi_unit)units[row->unit].scpi,
        .min = row->min,
        .max = row->max,
    };
}

/* From now on it is what was asked for, whatever bent it, or was to. */
static void put_quantity(struct dg_encoder *encoder, const struct dg_quantity *row, int64_t value)
{
    const struct dg_fault_target target = dg_encoder_target(encoder);

    dg_control_unfollow(encoder, (size_t)(row - dg_quantities));
    dg_fault_override(&encoder->faults, &target, row->offset);
    dg_quantity_set(row, encoder->world, value);
}

void dg_control_set_world(struct dg_scpi *self)
{
    const struct dg_quantity *row = &dg_quantities[self->command->argument];
    const struct dg_scpi_range range = dg_control_range(row);
    const bool state = row->unit == DG_UNIT_STATE;
    int64_t value = 0;
    bool flag = false;

    if (state ? !dg_scpi_flag(self, &flag) : !dg_scpi_number(self, &range, &value)) {
        return;
    }
    put_quantity(dg_control_selected(self), row, state ? flag : value);
    dg_control_changed(self);
}

void dg_control_world(struct dg_scpi *self)
{
    const struct dg_quantity *row = &dg_quantities[self->command->argument];
    const struct dg_encoder *encoder = dg_control_selected(self);

    dg_scpi_put_number(self, dg_quantity_get(row, encoder->world), units[row->unit].places);
}

void dg_control_heal(struct dg_scpi *self)
{
    struct dg_encoder *encoder = dg_control_selected(self);
    struct dg_world healthy;

    dg_world_init(&healthy);
    for (size_t i = 0; i < DG_QUANTITY_COUNT; i++) {
        const struct dg_quantity *row = &dg_quantities[i];
        put_quantity(encoder, row, dg_quantity_get(row, &healthy));
    }
}

void dg_control_healthy(struct dg_scpi *self)
{
    dg_control_heal(self);
    dg_control_changed(self);
}
