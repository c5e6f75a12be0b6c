/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of a BiSS encoder, and its EEPROM: in memory, or in a file.
 */
#ifndef DREHGEBER_LINUX_BISS_SETTINGS_H
#define DREHGEBER_LINUX_BISS_SETTINGS_H

#include "drehgeber/biss.h"
#include "nvm_file.h"
#include "nvm_memory.h"
#include "nvm_writer.h"
#include "stacks.h"

/** The protocol, as the port knows it; its settings are a struct dg_biss_model. */
extern const struct lx_stack lx_biss_stack;

/** On a simulated wire the master leaves an encoder the time it has of its own.
 * @return 0, or -1 with `error`: one was set */
int lx_biss_own_timeout(const struct lx_plan *plan, const struct lx_plan_encoder *encoder,
                        const struct dg_biss_model *model, struct lx_error *error);

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
