/* SPDX-License-Identifier: MIT */
/*
 * WORLd: what the selected encoder senses.
 */
#include "control_private.h"

#define MILLI_PLACES 3u

#define AT(member) offsetof(struct dg_world, member), sizeof(((struct dg_world *)0)->member)

/* A quantity; those of one byte are states. */
struct quantity {
    uint16_t offset;
    uint8_t size;
    uint8_t places; /* decimals of the answer, in the first unit of `range` */
    struct dg_scpi_range range;
};

#define STATE DG_SCPI_PLAIN, 0, 0, 1

/* clang-format off */
static const struct quantity quantities[CONTROL_QUANTITY_COUNT] = {
    [CONTROL_TEMPERATURE]         = {AT(temperature_mdegc),      MILLI_PLACES, {DG_SCPI_TEMPERATURE, 0, -273000, 1000000}},
    [CONTROL_LED_CURRENT]         = {AT(led_current_ua),         0,            {DG_SCPI_CURRENT,     0,       0, 1000000}},
    [CONTROL_SUPPLY]              = {AT(supply_mv),              0,            {DG_SCPI_VOLTAGE,     0,       0,  100000}},
    [CONTROL_BATTERY]             = {AT(battery_mv),             0,            {DG_SCPI_VOLTAGE,     0,       0,  100000}},
    [CONTROL_SIN_AMPLITUDE]       = {AT(sin_amplitude_permille), 0,            {DG_SCPI_PLAIN,       0,       0,    2000}},
    [CONTROL_COS_AMPLITUDE]       = {AT(cos_amplitude_permille), 0,            {DG_SCPI_PLAIN,       0,       0,    2000}},
    [CONTROL_SIN_OFFSET]          = {AT(sin_offset_permille),    0,            {DG_SCPI_PLAIN,       0,   -1000,    1000}},
    [CONTROL_COS_OFFSET]          = {AT(cos_offset_permille),    0,            {DG_SCPI_PLAIN,       0,   -1000,    1000}},
    [CONTROL_SINGLETURN]          = {AT(singleturn_ok),          0,            {STATE}},
    [CONTROL_MULTITURN_AMPLITUDE] = {AT(multiturn_amplitude_ok), 0,            {STATE}},
    [CONTROL_MULTITURN_SYNC]      = {AT(multiturn_sync_ok),      0,            {STATE}},
    [CONTROL_MULTITURN_VECTOR]    = {AT(multiturn_vector_ok),    0,            {STATE}},
    [CONTROL_EEPROM]              = {AT(eeprom_acknowledges),    0,            {STATE}},
    [CONTROL_WATCHDOG]            = {AT(watchdog_fired),         0,            {STATE}},
};
/* clang-format on */

static bool is_state(const struct quantity *row)
{
    return row->size == sizeof(bool);
}

/* From now on it is what was asked for, whatever bent it. */
static void put(struct dg_encoder *encoder, const struct quantity *row, int64_t value)
{
    const struct dg_fault_target target = dg_encoder_target(encoder);

    control_override(&encoder->faults, &target, row->offset);
    control_quantity_set(encoder->world, row->offset, row->size, value);
}

void control_set_world(struct dg_scpi *self, uint32_t argument)
{
    const struct quantity *row = &quantities[argument];
    int64_t value = 0;
    bool flag = false;

    if (is_state(row) ? !dg_scpi_flag(self, &flag) : !dg_scpi_number(self, &row->range, &value)) {
        return;
    }
    put(control_encoder(self), row, is_state(row) ? flag : value);
    control_changed(self);
}

void control_world(struct dg_scpi *self, uint32_t argument)
{
    const struct quantity *row = &quantities[argument];
    const struct dg_encoder *encoder = control_encoder(self);

    dg_scpi_put_number(self, control_quantity_get(encoder->world, row->offset, row->size),
                       row->places);
}

void control_heal(struct dg_scpi *self)
{
    struct dg_encoder *encoder = control_encoder(self);
    struct dg_world healthy;

    dg_world_init(&healthy);
    for (size_t i = 0; i < CONTROL_QUANTITY_COUNT; i++) {
        const struct quantity *row = &quantities[i];
        put(encoder, row, control_quantity_get(&healthy, row->offset, row->size));
    }
}

void control_healthy(struct dg_scpi *self, uint32_t argument)
{
    (void)argument;
    control_heal(self);
    control_changed(self);
}
