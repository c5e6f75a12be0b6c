/* SPDX-License-Identifier: MIT */
/**
 * @file
 * --set KEY=VALUE of a BiSS encoder, and its EEPROM: in memory, or in a file.
 */
#ifndef DREHGEBER_LINUX_BISS_SETTINGS_H
#define DREHGEBER_LINUX_BISS_SETTINGS_H

#include <stdio.h>

#include "drehgeber/biss.h"
#include "nvm_file.h"
#include "nvm_memory.h"
#include "nvm_writer.h"
#include "plan.h"
#include "settings.h"

/** What the table's rows point into. */
struct lx_biss_settings {
    struct dg_biss_model model;
    struct lx_settings common; /**< the world in it */
};

/** The figures of `model` in a healthy world. */
void lx_biss_settings_init(struct lx_biss_settings *self, const struct dg_biss_model *model);

/** Apply "key=value". @return 0, or -1 with one line that names what would be right */
int lx_biss_settings_set(struct lx_biss_settings *self, const char *assignment,
                         struct lx_error *error);

/** Whether the figures fit together, once all are set. @return as lx_biss_settings_set() */
int lx_biss_settings_check(const struct lx_biss_settings *self, struct lx_error *error);

/** The figures of an encoder of a plan. @return 0, or -1 with one line in `error` that names its
 * place */
int lx_biss_settings_plan(struct lx_biss_settings *self, const struct lx_plan *plan,
                          const struct lx_plan_encoder *encoder, struct lx_error *error);

/** Set the serial number: up to 4294967295. @return as lx_biss_settings_set() */
int lx_biss_settings_serial(struct lx_biss_settings *self, const char *digits,
                            struct lx_error *error);

/** The encoder's own keys with ranges and what they are; for --help. */
void lx_biss_settings_help(FILE *to);

/** Where the bytes of an EEPROM are. Not to be moved while `nvm` is in use. */
struct lx_biss_eeprom {
    struct lx_nvm_memory memory; /**< the delivery state; the EEPROM itself without a file */
    struct lx_nvm_file file;     /**< fd -1: not open */
    struct lx_nvm_queue queue;   /**< in front of it, when there is a writer */
    struct dg_nvm nvm;           /**< for the device */
};

/** Open it; `path` NULL: in memory. A new file gets the delivery state.
 * @return 0, or -1 with one line in `error` */
int lx_biss_eeprom_open(struct lx_biss_eeprom *self, const char *path, struct lx_error *error);

/** Let the writer (NULL: nobody) write the file from here on. @return 0, or -1 with one line in
 * `error` */
int lx_biss_eeprom_defer(struct lx_biss_eeprom *self, struct lx_nvm_writer *writer,
                         struct lx_error *error);

/** Close the file, free the memory; also after a failed open. */
void lx_biss_eeprom_close(struct lx_biss_eeprom *self);

/** Make `device` and switch it on at `now`. `path` is that of the EEPROM in `setup`, for messages.
 * @return 0, or -1 with one line in `error` */
int lx_biss_switch_on(struct dg_biss *device, const struct dg_biss_setup *setup, dg_ns now,
                      const char *path, struct lx_error *error);

#endif
