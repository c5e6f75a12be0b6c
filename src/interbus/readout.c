/* SPDX-License-Identifier: MIT */
/*
 * The read-out mode (manual 5.4.3, 9.2): while an item is in force, IN is A0000000h and its value,
 * read anew in every cycle.
 */
#include "interbus_private.h"

/* Item 202100xDh has the register's number in bits 7..4. */
#define OPC_ITEM 0x0Du

static uint32_t serial(const struct dg_ib *self)
{
    return self->setup.model->serial;
}

static uint32_t steps(const struct dg_ib *self)
{
    return self->steps;
}

static uint32_t revolutions(const struct dg_ib *self)
{
    return self->revolutions;
}

static uint32_t direction(const struct dg_ib *self)
{
    return self->direction;
}

static uint32_t preset(const struct dg_ib *self)
{
    return self->preset;
}

static uint32_t shift_readout(const struct dg_ib *self)
{
    return self->shift;
}

static uint32_t preset_flag(const struct dg_ib *self)
{
    return self->preset_flag ? 1 : 0;
}

static uint32_t version(const struct dg_ib *self)
{
    return self->setup.model->version;
}

static uint32_t time_10min(const struct dg_ib *self)
{
    return self->time_10min;
}

static uint32_t start_up_mode(const struct dg_ib *self)
{
    return self->mode;
}

static uint32_t flags(const struct dg_ib *self)
{
    const struct dg_ib_model *model = self->setup.model;

    return (model->steps_minus_one ? 1u : 0u) | (model->turns > 1 ? 2u : 0u);
}

/* In 0.1 degC, to the nearest, away from zero in the middle. */
static uint32_t temperature(const struct dg_ib *self)
{
    int32_t mdegc = self->setup.world->temperature_mdegc;

    return (uint32_t)(mdegc / 100 + mdegc % 100 / 50);
}

static uint32_t (*const items[])(const struct dg_ib *self) = {
    [0x0] = serial,     [0x1] = steps,         [0x2] = revolutions, [0x3] = direction,
    [0x4] = preset,     [0x5] = shift_readout, [0x6] = preset_flag, [0x7] = version,
    [0x8] = time_10min, [0x9] = start_up_mode, [0xA] = flags,       [0xC] = temperature,
};
#define ITEMS DG_COUNT(items)
#define TEMPERATURE 0xCu

uint32_t dg_ib_item(const struct dg_ib *self)
{
    uint32_t item = self->item & 0xFFFFu;

    if ((item & 0xFF0Fu) == OPC_ITEM) {
        return DG_IB_READ_OUT | self->opc[item >> 4];
    }
    bool fitted = item != TEMPERATURE || self->setup.model->temperature_sensor;
    if (item >= ITEMS || items[item] == NULL || !fitted) {
        return DG_IB_UNKNOWN_ITEM | (self->item & DG_IB_DATA_MASK); /* I24 */
    }
    return DG_IB_READ_OUT | (items[item](self) & DG_IB_DATA_MASK);
}

uint32_t dg_ib_read_out(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)now;
    self->item = word;
    return dg_ib_item(self);
}
