/* SPDX-License-Identifier: MIT */
/**
 * @file
 * --set KEY=VALUE for a ring of INTERBUS encoders and for each of them: figures of their own, and
 * the world's keys of settings.h.
 */
#ifndef DREHGEBER_LINUX_MODBUS_SETTINGS_H
#define DREHGEBER_LINUX_MODBUS_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "drehgeber/interbus.h"
#include "plan.h"
#include "settings.h"

/** A figure that was not set: each model's own. */
#define LX_AS_MODEL (-1)

/** What the table's rows point into. */
struct lx_ring_settings {
    struct lx_settings common; /**< its world is what the encoder senses */
    int32_t cycle_us;
    int32_t tear; /**< 1: half of an OUT word is taken (fault) */
    int32_t
        break_at; /**< index of the device whose incoming bus is cut (fault); LX_AS_MODEL: none */
    int32_t steps;
    int32_t turns; /**< not of a K1 */
    int32_t steps_minus_one;
    int32_t temperature_sensor;
    int32_t loop;
    int32_t param_cycles;
    int32_t self_test_ms;
    int32_t version;
    int32_t serial;
};

/** Nothing set, in a healthy world. */
void lx_ring_settings_init(struct lx_ring_settings *self);

/** Apply "key=value". @return 0, or -1 with one line that names what would be right */
int lx_ring_settings_set(struct lx_ring_settings *self, const char *assignment,
                         struct lx_error *error);

/** Apply a setting of a plan: of the ring, or of one of its encoders.
 * @return 0, or -1 with one line in `error` that names its place */
int lx_ring_settings_take(struct lx_ring_settings *self, const struct lx_plan *plan,
                          const struct lx_plan_setting *setting, bool of_ring,
                          struct lx_error *error);

/** Set the serial number: up to 33554431. @return as lx_ring_settings_set() */
int lx_ring_settings_serial(struct lx_ring_settings *self, const char *digits,
                            struct lx_error *error);

/** `model` with these figures; its serial number counts up by `index`. */
struct dg_ib_model lx_ring_settings_model(const struct lx_ring_settings *self,
                                          const struct dg_ib_model *model, uint32_t index);

/** The ring's own keys with ranges and what they are; for --help. */
void lx_ring_settings_help(FILE *to);

#endif
