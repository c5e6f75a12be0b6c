/* SPDX-License-Identifier: MIT */
/**
 * @file
 * --set KEY=VALUE: one table of everything about an encoder that can be set from outside.
 */
#ifndef DREHGEBER_LINUX_SETTINGS_H
#define DREHGEBER_LINUX_SETTINGS_H

#include <stdbool.h>
#include <stdio.h>

#include "drehgeber/hiperface.h"
#include "drehgeber/world.h"
#include "plan.h"
#include "say.h"

/** Room for the names of a stack's own keys. */
#define LX_OWN_KEYS_MAX 192u

/** What the table's rows point into. Once all are set, lx_settings_world() hands on the world. */
struct lx_settings {
    struct dg_hf_model model; /**< factory figures */
    struct dg_world world;    /**< what the encoder senses */
    bool pace;                /**< requests and replies take the time they take on a line */
    bool any_line;            /**< whatever the line is set to is right */
    dg_ns sincos;             /**< sine and cosine in a trace: time between samples; 0: none */
    bool serial_given;        /**< the serial number was asked for, not left to the model */
    bool rs485;               /**< an RS485 encoder; another one only has a world */
    uint8_t address;          /**< RS485: of a new EEPROM; 0: as delivered */
    const char *wire_keys; /**< keys of the wire, with blanks between them, or NULL; only named */
    char own_keys[LX_OWN_KEYS_MAX]; /**< keys beside this table's, see lx_settings_name() */
};

/** The figures of `model` in a healthy world; NULL: not an RS485 encoder. */
void lx_settings_init(struct lx_settings *self, const struct dg_hf_model *model);

/** Let whoever mistypes a key read that the encoder also has `key`, which its stack takes itself.
 */
void lx_settings_name(struct lx_settings *self, const char *key);

/** Apply "key=value". @return 0, or -1 with one line that names what would be right */
int lx_settings_set(struct lx_settings *self, const char *assignment, struct lx_error *error);

/** Longest "key=value" of a plan, with its zero. */
#define LX_ASSIGNMENT_MAX 256u

/** A setting of a plan as "key=value". @return 0, or -1 with one line in `error` that names its
 * place */
int lx_settings_assignment(char to[LX_ASSIGNMENT_MAX], const struct lx_plan *plan,
                           const struct lx_plan_setting *setting, struct lx_error *error);

/** Apply a setting of a plan. @return 0, or -1 with one line in `error` that names its place */
int lx_settings_take(struct lx_settings *self, const struct lx_plan *plan,
                     const struct lx_plan_setting *setting, struct lx_error *error);

/** Set the serial number: 1 to 9 digits, zeros in front. @return as lx_settings_set() */
int lx_settings_serial(struct lx_settings *self, const char *digits, struct lx_error *error);

/** All that the encoder senses but its shaft, to the world it lives in. */
void lx_settings_world(const struct lx_settings *self, struct dg_world *to);

/** Turn an error about "--set KEY=VALUE" or "--serial N" into one about line `line` of the plan's
 * file; one about the command line (0) stays as it is. Always -1. */
int lx_settings_refuse(const struct lx_plan *plan, lx_line_number line, struct lx_error *error);

/** Whether the figures fit each other. @return 0, or -1 with one line in `error` */
int lx_settings_check(const struct lx_settings *self, struct lx_error *error);

/** All keys with ranges, defaults of `self`, and what they are; for --help. */
void lx_settings_help(const struct lx_settings *self, FILE *to);

#endif
