/* SPDX-License-Identifier: MIT */
/*
 * Bits of the EEPROM that change by themselves, and what the devices say to it when they start.
 *
 * A note of what was done: bits 15..0 the region's sum, 23..16 the byte's value since, 31..24 the
 * bit, 63..32 its address.
 */
#include "control_private.h"
#include "drehgeber/biss.h"
#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"

#define NOTE_VALUE 16u
#define NOTE_MASK 24u
#define NOTE_ADDRESS 32u

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
static int flip(const struct dg_fault_target *target, uint32_t address, uint8_t mask,
                uint8_t *value)
{
    const int result = read_byte(target, address, value);

    *value ^= mask;
    return result == DG_OK ? write_byte(target, address, *value) : result;
}

static uint8_t mask_of(uint32_t bit)
{
    return (uint8_t)(1u << bit % 8u);
}

int control_flip(const struct dg_fault_target *target, uint8_t region, uint32_t bit)
{
    uint8_t value = 0;

    return flip(target, address_of(target, region, bit), mask_of(bit), &value);
}

int control_damage(const struct dg_fault_target *target, uint8_t region, uint32_t bit,
                   int64_t *note)
{
    const uint32_t address = address_of(target, region, bit);
    uint16_t sum = 0;
    uint8_t value = 0;

    if (read_sum(target, region, &sum) != DG_OK ||
        flip(target, address, mask_of(bit), &value) != DG_OK) {
        return DG_ERR_IO;
    }
    const uint64_t what = (uint64_t)address << NOTE_ADDRESS | (uint64_t)mask_of(bit) << NOTE_MASK |
                          (uint64_t)value << NOTE_VALUE | sum;
    *note = (int64_t)what;
    return DG_OK;
}

int control_mend(const struct dg_fault_target *target, uint8_t region, int64_t note)
{
    const uint64_t what = (uint64_t)note;
    const uint32_t address = (uint32_t)(what >> NOTE_ADDRESS);
    const uint8_t value = (uint8_t)(what >> NOTE_VALUE);
    uint16_t sum = 0;
    uint8_t byte = 0;

    if (read_sum(target, region, &sum) != DG_OK || read_byte(target, address, &byte) != DG_OK) {
        return DG_ERR_IO;
    }
    if (sum != (uint16_t)what || byte != value) {
        return DG_OK; /* written since: the damage is gone already */
    }
    return write_byte(target, address, (uint8_t)(byte ^ (uint8_t)(what >> NOTE_MASK)));
}

/* clang-format off */
/* The last row of a stack is for all other regions. */
static const struct {
    const struct dg_stack *stack;
    const char *region; /* NULL: any other */
    const char *effect;
    const char *chapter;
} effects[] = {
    {&dg_hf_stack, NULL,   "from the next start on: the region's code, then 06h on the error stack; commands bound to it answer 02h, 03h, 05h or 06h", "5.1.3"},
    {&dg_biss_stack,      NULL,   "from the next start or command 04 on: 69h bit 4, nERR low; a damaged 'config' has its defaults", "5.2.3"},
    {&dg_cia406_stack,   "usf",  "from the next start on, with the universal scaling function: EMCY 6200h until a preset is set", "25"},
    {&dg_cia406_stack,   "time", "from the next start on: EMCY 5100h; 6508h begins anew", "15; F36x8 no. 9"},
    {&dg_cia406_stack,   NULL,   "from the next start on: EMCY 5100h, 1001h bit 0, defaults in force", "15; CANopen no. 4"},
    {&dg_ib_stack,  "time", "from the next start on: the operating time begins anew; no error", "I17"},
    {&dg_ib_stack,  NULL,   "from the next start on: IN 86000000h until it is sent again or 0E000000h is accepted", "9.4; I17"},
};
/* clang-format on */

static size_t effect_of(const struct dg_stack *stack, const char *region)
{
    size_t i = 0;

    while (effects[i].stack != stack ||
           (effects[i].region != NULL && !control_same(effects[i].region, region))) {
        i++;
    }
    return i;
}

const char *control_damage_effect(const struct dg_stack *stack, const char *region)
{
    return effects[effect_of(stack, region)].effect;
}

const char *control_damage_chapter(const struct dg_stack *stack, const char *region)
{
    return effects[effect_of(stack, region)].chapter;
}
