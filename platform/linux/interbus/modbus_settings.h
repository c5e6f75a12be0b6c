/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of an INTERBUS encoder.
 */
#ifndef DREHGEBER_LINUX_MODBUS_SETTINGS_H
#define DREHGEBER_LINUX_MODBUS_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/bus_words.h"
#include "drehgeber/interbus.h"
#include "stacks.h"

/** The protocol, as the port knows it; its settings are a struct dg_ib_model. */
extern const struct lx_stack lx_ib_stack;

#endif
