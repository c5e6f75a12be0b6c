/* SPDX-License-Identifier: MIT */
/*
 * S36 BiSS. Identities are examples; the command line changes them.
 */
#include "drehgeber/biss.h"
#include "drehgeber/devices.h"

/* What both S36 share: manual 5.2.1.3, EDS; times of a serial EEPROM and busy are chosen. */
#define S36_BISS                                                                                   \
    .singleturn_bits = 21, .life_counter = true, .sl_low_at_start = true, .serial = 123456789,     \
    .device_id = {0x04, 0x00, 0xC0, 0x00, 0x00, 0x00, 0x4B, 0x55}, .profile_id = 0x62,             \
    .busy = DG_US(3), .eeprom_read = DG_US(100), .eeprom_write = DG_MS(5), .init = DG_MS(100),     \
    .hint = DG_MS(100)

static const struct dg_biss_model s3674_biss = {S36_BISS, .multiturn_bits = 0};
static const struct dg_biss_model s3684_biss = {S36_BISS, .multiturn_bits = 12};

const struct dg_device dg_s3674_biss = {"s3674-biss",   "BiSS-C",    "21 bit, singleturn",
                                        &dg_biss_stack, &s3674_biss, 0};
const struct dg_device dg_s3684_biss = {"s3684-biss",   "BiSS-C",    "21 bit, 4096 turns",
                                        &dg_biss_stack, &s3684_biss, 0};
