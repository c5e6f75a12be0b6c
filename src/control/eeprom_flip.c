/* SPDX-License-Identifier: MIT */
/*
 * Bits of the EEPROM that change by themselves, and what the devices say to it when they start.
 */
#include "control_private.h"
#include "drehgeber/bits.h"

/* Of a checked region, behind its bytes. */
static int read_sum(const struct dg_fault_target *target, uint8_t region, uint16_t *sum)
{
    uint8_t bytes[2];
    const uint32_t end =
        dg_store_address(target->layout, region) + target->layout->regions[region].size;
    const int result = target->nvm.ops->read(target->nvm.ctx, end, bytes, sizeof bytes);

    *sum = dg_load_be16(bytes);
    return result;
}

static int read_byte(const struct dg_fault_target *target, uint32_t address, uint8_t *byte)
{
    return target->nvm.ops->read(target->nvm.ctx, address, byte, 1);
}

static int write_byte(const struct dg_fault_target *target, uint32_t address, uint8_t byte)
{
    const struct dg_nvm *nvm = &target->nvm;
    const int result = nvm->ops->write(nvm->ctx, address, &byte, 1);

    return result == DG_OK && nvm->ops->sync != NULL ? nvm->ops->sync(nvm->ctx) : result;
}

static uint32_t address_of(const struct dg_fault_target *target, uint8_t region, uint32_t bit)
{
    return dg_store_address(target->layout, region) + bit / 8u;
}

/* @param value the byte since */
static int flip_bits(const struct dg_fault_target *target, uint32_t address, uint8_t mask,
                     uint8_t *value)
{
    const int result = read_byte(target, address, value);

    *value ^= mask;
    return result == DG_OK ? write_byte(target, address, *value) : result;
}

static uint8_t bit_mask_of(uint32_t bit)
{
    return (uint8_t)(1u << bit % 8u);
}

int dg_control_flip(const struct dg_fault_target *target, uint8_t region, uint32_t bit)
{
    uint8_t value = 0;

    return flip_bits(target, address_of(target, region, bit), bit_mask_of(bit), &value);
}

int dg_control_damage(const struct dg_fault_target *target, uint8_t region, uint32_t bit,
                      struct dg_fault_flip *done)
{
    struct dg_fault_flip now = {.address = address_of(target, region, bit),
                                .mask = bit_mask_of(bit)};

    if (read_sum(target, region, &now.sum) != DG_OK ||
        flip_bits(target, now.address, now.mask, &now.value) != DG_OK) {
        return DG_ERR_IO;
    }
    *done = now;
    return DG_OK;
}

int dg_control_mend(const struct dg_fault_target *target, uint8_t region,
                    const struct dg_fault_flip *done)
{
    uint16_t sum = 0;
    uint8_t byte = 0;

    if (read_sum(target, region, &sum) != DG_OK ||
        read_byte(target, done->address, &byte) != DG_OK) {
        return DG_ERR_IO;
    }
    if (sum != done->sum || byte != done->value) {
        return DG_OK; /* written since: the damage is gone already */
    }
    return write_byte(target, done->address, (uint8_t)(byte ^ done->mask));
}

const struct dg_damage_row *dg_control_damage_of(const struct dg_instrument *instrument,
                                                 const char *region)
{
    const struct dg_damage_row *row = instrument->damage;

    while (row->region != NULL && !dg_control_same(row->region, region)) {
        row++;
    }
    return row;
}
