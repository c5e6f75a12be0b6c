/* SPDX-License-Identifier: MIT */
/*
 * What can be set of an OCD INTERBUS.
 */
#include "drehgeber/interbus.h"

#define AT(field) offsetof(struct dg_ib_model, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name                unit      offset                  type        places factor min             max  words           help */
    {"steps",              "",       AT(steps),              DG_KEY_U16,  0, 1,       1, DG_IB_STEPS_MAX, NULL,          "steps of the discs per turn (factory)"},
    {"turns",              "",       AT(turns),              DG_KEY_U16,  0, 1,       1, DG_IB_TURNS_MAX, NULL,          "turns of a K2 or K3; 1: singleturn (factory)"},
    {"steps_minus_one",    "",       AT(steps_minus_one),    DG_KEY_FLAG, 0, 1,       0,                1, dg_key_no_yes, "1: a K3 has one step more than its parameter says (factory)"},
    {"temperature_sensor", "",       AT(temperature_sensor), DG_KEY_FLAG, 0, 1,       0,                1, dg_key_no_yes, "1: a K3 has a temperature sensor (factory)"},
    {"loop",               "",       AT(loop),               DG_KEY_FLAG, 0, 1,       0,                1, dg_key_no_yes, "1: INTERBUS Loop, with ID B2h and B3h (factory)"},
    {"param_cycles",       "cycles", AT(param_cycles),       DG_KEY_U8,   0, 1,       1,              255, NULL,          "cycles from a K3's command to its answer"},
    {"self_test_ms",       "ms",     AT(self_test),          DG_KEY_NS,   0, 1000000, 0,             1000, NULL,          "time for the self-test after power-on"},
    {"version",            "",       AT(version),            DG_KEY_U32,  0, 1,       0,  DG_IB_DATA_MASK, NULL,          "software version of a K3 (factory)"},
    {"serial",             "",       AT(serial),             DG_KEY_U32,  0, 1,       0,  DG_IB_DATA_MASK, NULL,          "serial number"},
};
/* clang-format on */

const struct dg_keys dg_ib_keys = {rows, DG_COUNT(rows)};
