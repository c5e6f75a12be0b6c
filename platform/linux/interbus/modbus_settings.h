/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of an INTERBUS encoder, and of the ring it is in.
 */
#ifndef DREHGEBER_LINUX_MODBUS_SETTINGS_H
#define DREHGEBER_LINUX_MODBUS_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/bus_words.h"
#include "drehgeber/interbus.h"
#include "stacks.h"

/** The settings of a ring. */
struct lx_ring_settings {
    uint32_t cycle_us;
    bool tear;         /**< half of an OUT word is taken (fault) */
    uint16_t break_at; /**< index of the device whose incoming bus is cut (fault), or
                            DG_RING_WHOLE */
};

/** The protocol, as the port knows it; its settings are a struct dg_ib_model. */
extern const struct lx_stack lx_ib_stack;

/** The keys of the ring; offsets count from a struct lx_ring_settings. */
extern const struct dg_keys lx_ring_keys;

/** 1 ms, and no faults. */
extern const struct lx_ring_settings lx_ring_defaults;

/** The model as it was set; its serial number counts up by `index`. */
struct dg_ib_model lx_ib_settings_model(const struct dg_ib_model *settings, uint32_t index);

#endif
