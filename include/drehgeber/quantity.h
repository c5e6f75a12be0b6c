/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What an encoder senses beside its shaft: one row for each quantity of struct dg_world. Healthy
 * values (dg_world_init()), SCPI commands (WORLd:...), settings of hosts and help are made of
 * these rows by whoever needs them, so that an image carries no text it has no use for. A new
 * quantity is a row here and a member of struct dg_world.
 */
#ifndef DREHGEBER_QUANTITY_H
#define DREHGEBER_QUANTITY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * ROW(ID, member, name, header, unit, healthy, min, max, multiturn, help) for each quantity:
 * DG_QUANTITY_ID; its member of struct dg_world; its name as a setting; its SCPI header behind
 * WORLd:; DG_UNIT_unit, which healthy, min and max are counted in; whether only the multiturn part
 * of an encoder senses it; what it is.
 */
/* clang-format off */
#define DG_QUANTITIES(ROW)                                                                                                                                                                                    \
    /*  ID                   member                  name                      header                 unit      healthy     min      max  multi  help */                                                    \
    ROW(TEMPERATURE,         temperature_mdegc,      "temperature",            "TEMPerature",         MDEGC,      37000, -273000, 1000000, false, "in the housing")                                         \
    ROW(LED_CURRENT,         led_current_ua,         "led_current_ua",         "LED:CURRent",         UA,         12000,       0, 1000000, false, "of the optical scanner's LED")                           \
    ROW(SUPPLY,              supply_mv,              "supply_mv",              "SUPPly",              MV,          5000,       0,  100000, false, "supply voltage")                                         \
    ROW(BATTERY,             battery_mv,             "battery_mv",             "BATTery",             MV,          3610,       0,  100000, true,  "battery of the multiturn counter")                       \
    ROW(SIN_AMPLITUDE,       sin_amplitude_permille, "sin_amplitude_permille", "AMPLitude:SIN",       PERMILLE,    1000,       0,    2000, false, "of the nominal amplitude")                               \
    ROW(COS_AMPLITUDE,       cos_amplitude_permille, "cos_amplitude_permille", "AMPLitude:COS",       PERMILLE,    1000,       0,    2000, false, "of the nominal amplitude")                               \
    ROW(SIN_OFFSET,          sin_offset_permille,    "sin_offset_permille",    "OFFSet:SIN",          PERMILLE,       0,   -1000,    1000, false, "of the nominal amplitude")                               \
    ROW(COS_OFFSET,          cos_offset_permille,    "cos_offset_permille",    "OFFSet:COS",          PERMILLE,       0,   -1000,    1000, false, "of the nominal amplitude")                               \
    ROW(SINGLETURN,          singleturn_ok,          "singleturn_ok",          "SINGleturn",          STATE,          1,       0,       1, false, "the singleturn track can be read")                       \
    ROW(MULTITURN_AMPLITUDE, multiturn_amplitude_ok, "multiturn_amplitude_ok", "MULTiturn:AMPLitude", STATE,          1,       0,       1, true,  "the multiturn sensor's amplitude is sufficient")         \
    ROW(MULTITURN_SYNC,      multiturn_sync_ok,      "multiturn_sync_ok",      "MULTiturn:SYNC",      STATE,          1,       0,       1, true,  "multiturn and singleturn agree")                         \
    ROW(MULTITURN_VECTOR,    multiturn_vector_ok,    "multiturn_vector_ok",    "MULTiturn:VECTor",    STATE,          1,       0,       1, true,  "the multiturn sensor's vector length is in range")       \
    ROW(EEPROM,              eeprom_acknowledges,    "eeprom_acknowledges",    "EEPRom",              STATE,          1,       0,       1, false, "the EEPROM acknowledges")                                \
    ROW(WATCHDOG,            watchdog_fired,         "watchdog_fired",         "WATChdog",            STATE,          0,       0,       1, false, "the watchdog has reset the processor")
/* clang-format on */

/** What quantities are counted in. */
enum dg_unit {
    DG_UNIT_MDEGC,    /**< 0.001 degC */
    DG_UNIT_UA,       /**< uA */
    DG_UNIT_MV,       /**< mV */
    DG_UNIT_PERMILLE, /**< of something nominal */
    DG_UNIT_STATE,    /**< bool */
    DG_UNIT_COUNT     /**< how many units there are */
};

/** The quantities, in the order of DG_QUANTITIES. */
enum dg_quantity_id {
#define DG_QUANTITY_ID(id, ...) DG_QUANTITY_##id,
    DG_QUANTITIES(DG_QUANTITY_ID)
#undef DG_QUANTITY_ID
        DG_QUANTITY_COUNT /**< how many quantities there are */
};

/** Where a quantity lies and what it may be. */
struct dg_quantity {
    uint16_t offset; /**< in struct dg_world */
    uint8_t size;    /**< in bytes: 1 (bool), 2 or 4 */
    uint8_t unit;    /**< enum dg_unit */
    bool multiturn;  /**< only the multiturn part of an encoder senses it */
    int32_t min;     /**< smallest value it may be given */
    int32_t max;     /**< largest value */
};

/** The quantities by enum dg_quantity_id. */
DG_API extern const struct dg_quantity dg_quantities[DG_QUANTITY_COUNT];

/** The quantity at `offset` of struct dg_world, or NULL. */
DG_API const struct dg_quantity *dg_quantity_at(size_t offset);

/** Its value in `world`. */
DG_API int64_t dg_quantity_get(const struct dg_quantity *self, const struct dg_world *world);

/** Set it; `value` is within its limits. */
DG_API void dg_quantity_set(const struct dg_quantity *self, struct dg_world *world, int64_t value);

#ifdef __cplusplus
}
#endif

#endif
