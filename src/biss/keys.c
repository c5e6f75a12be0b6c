/* SPDX-License-Identifier: MIT */
/*
 * What can be set of an S36 BiSS.
 */
#include "drehgeber/biss.h"

#define AT(field) offsetof(struct dg_biss_model, field)
#define NS(limit) DG_BISS_##limit##_MAX_NS
#define BITS(of) DG_BISS_##of##TURN_BITS_MAX
#define US(limit) (DG_BISS_##limit##_MAX_NS / DG_US(1))

static const char *const stop_bits[2] = {"own", "early"};

/* clang-format off */
static const struct dg_key rows[] = {
    /* name             unit  offset                type       places factor min         max  words           help */
    {"serial",          "",   AT(serial),           DG_KEY_U32,  0, 1,        0, UINT32_MAX, NULL,          "serial number"},
    {"mt",              "",   AT(multiturn_bits),   DG_KEY_U8,   0, 1,        0,  BITS(MULTI), NULL,          "multiturn bits"},
    {"st",              "",   AT(singleturn_bits),  DG_KEY_U8,   0, 1, DG_BISS_SINGLETURN_BITS_MIN, BITS(SINGLE), NULL,          "singleturn bits"},
    {"lc",              "",   AT(life_counter),     DG_KEY_FLAG, 0, 1,        0,          1, dg_key_no_yes, "1: the frame has a life counter"},
    {"autostore",       "",   AT(autostore),        DG_KEY_FLAG, 0, 1,        0,          1, dg_key_no_yes, "1: the encoder stores offsets and masks in the EEPROM as they are written"},
    {"busy_us",         "us", AT(busy),             DG_KEY_NS,   3, 1,        0,   NS(BUSY_S), NULL,          "time from the first clock edge to the start bit"},
    {"busy_jitter_us",  "us", AT(busy_jitter),      DG_KEY_NS,   3, 1,        0,   NS(BUSY_S), NULL,          "busy_us becomes longer by a random time up to this one in every frame"},
    {"sl_low_at_start", "",   AT(sl_low_at_start),  DG_KEY_FLAG, 0, 1,        0,          1, dg_key_no_yes, "1: SLO is low from power-on to the first clock"},
    {"hint_us",         "us", AT(hint),             DG_KEY_NS,   0, 1000,     0,   10000000, NULL,          "if SLO is low and MA has no pulse for this time, a note explains why a master may hang; 0: never"},
    {"stop_bit",        "",   AT(stop_bit_early),   DG_KEY_FLAG, 0, 1,        0,          1, stop_bits,     "P = 1 refuses the register that was just transferred (own), or already the next one (early)"},
    {"eeprom_read_us",  "us", AT(eeprom_read),      DG_KEY_NS,   0, 1000,     0,       1000, NULL,          "time for an access to a user bank"},
    {"eeprom_write_us", "us", AT(eeprom_write),     DG_KEY_NS,   0, 1000,     0,      19000, NULL,          "time that the EEPROM needs after a write"},
    {"timeout_us",      "us", AT(timeout),          DG_KEY_NS,   0, 1000,     0,  US(TIMEOUT), NULL,          "a pause on MA of this length ends a frame; slow lines need at least 13; 0: the encoder's own timeout"},
    {"init_ms",         "ms", AT(init),             DG_KEY_NS,   0, 1000000,  0,     600000, NULL,          "time for initialisation after power-on and reset"},
};
/* clang-format on */

const struct dg_keys dg_biss_keys = {rows, DG_COUNT(rows)};
