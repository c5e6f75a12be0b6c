/* SPDX-License-Identifier: MIT */
/*
 * The electronic data sheet (5.2.1.3): two banks of constants, the entries that follow from the
 * model's figures, and a check sum at the end of each.
 */
#include <string.h>

#include "biss_private.h"
#include "drehgeber/bits.h"

#define CHECKSUM 0x3Fu
#define TBUSY_S_UNIT_NS 250u
#define TBUSY_S_MIN 0x16u
/* Coarse bits: 2048 signal periods a turn. */
#define COARSE_BITS 11u

/* 5.2.1.3.1 */
static const uint8_t common[] = {
    [0x00] = 0x01, /* EDS_VER */
    [0x01] = 0x02, /* EDS_LEN: banks */
    [0x02] = DG_BISS_BANK_USER_FIRST,
    [0x03] = DG_BISS_BANK_USER_LAST,
    [0x04] = 0x64, /* TMA: 100 ns */
    [0x05] = 0x28, /* TO_MIN: 10 us */
    [0x06] = 0x44, /* TO_MAX: 17 us */
    [0x07] = 0x28, /* TOS_MIN: 1 us */
    [0x08] = 0x44, /* TOS_MAX: 1.7 us */
    [0x0F] = 0x64, /* PON_DLY: 100 ms */
    [0x10] = 0x01, /* DC_NUM */
    [0x11] = 0x01, /* SL_NUM */
    [0x14] = 0x04, /* BANK1 */
    [0x16] = 0x0A, /* FORMAT1 */
    [0x17] = 0x21, /* CPOLY1: 43h without its last bit */
};

/* 5.2.1.3.2 */
static const uint8_t profile[] = {
    [0x00] = 0x01,                       /* BP_VER */
    [0x01] = 0x01,                       /* BP_LEN: banks */
    [0x04] = 0x01,                       /* FB1: error bit */
    [0x05] = 0x02,                       /* FB2: warning bit */
    [0x06] = 0x64,                       /* PON_PDL */
    [0x09] = 0x01,                       /* POS_NUM */
    [0x0C] = COARSE_BITS, [0x0D] = 0x01, /* CO_FMT */
    [0x0F] = 0x01,                       /* FI_FMT */
    [0x16] = 0x08,                       /* SIP_CNT: 2048 */
    [0x1F] = 0x21,                       /* CPOLY */
};

static uint8_t finish_bank(uint8_t *bank, uint8_t offset)
{
    uint8_t sum = 0;

    for (uint8_t i = 0; i < CHECKSUM; i++) {
        sum = (uint8_t)(sum + bank[i]);
    }
    bank[CHECKSUM] = sum;
    return bank[offset];
}

uint8_t dg_biss_eds_common(const struct dg_biss_model *model, uint8_t offset)
{
    uint8_t bank[DG_BISS_BANK_SIZE] = {0};
    const dg_ns most = model->busy + model->busy_jitter;
    const dg_ns busy = (most + TBUSY_S_UNIT_NS - 1u) / TBUSY_S_UNIT_NS;

    memcpy(bank, common, sizeof common);
    bank[0x0C] = busy > TBUSY_S_MIN ? (uint8_t)busy : TBUSY_S_MIN;
    bank[0x15] = (uint8_t)(dg_biss_position_bits(model) + dg_biss_life_bits(model));
    return finish_bank(bank, offset);
}

uint8_t dg_biss_eds_profile(const struct dg_biss_model *model, uint8_t offset)
{
    uint8_t bank[DG_BISS_BANK_SIZE] = {0};
    const uint8_t st = model->singleturn_bits;
    const uint8_t fine = st > COARSE_BITS ? (uint8_t)(st - COARSE_BITS) : 0;

    memcpy(bank, profile, sizeof profile);
    bank[0x02] = model->profile_id;
    bank[0x03] = dg_biss_position_bits(model);
    bank[0x0A] = model->multiturn_bits;
    bank[0x0E] = fine;
    if (model->multiturn_bits > 0) {
        dg_store_be32(&bank[0x10], (uint32_t)((uint64_t)1 << model->multiturn_bits));
    }
    dg_store_be32(&bank[0x18], (uint32_t)1 << fine);
    return finish_bank(bank, offset);
}
