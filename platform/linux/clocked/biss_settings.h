/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of a BiSS encoder, and its EEPROM: in memory, or in a file.
 */
#ifndef DREHGEBER_LINUX_BISS_SETTINGS_H
#define DREHGEBER_LINUX_BISS_SETTINGS_H

#include "drehgeber/biss.h"
#include "image.h"
#include "stacks.h"

/** The protocol, as the port knows it; its settings are a struct dg_biss_model. */
extern const struct lx_stack lx_biss_stack;

/** On a simulated wire the master leaves an encoder the time it has of its own.
 * @return 0, or -1 with `error`: one was set */
int lx_biss_own_timeout(const struct lx_plan *plan, const struct lx_plan_encoder *encoder,
                        const struct dg_biss_model *model, struct lx_error *error);

/** An EEPROM. All zero: not open. Not to be moved while it is. */
struct lx_biss_memory {
    struct lx_image image;
    struct lx_image_part part;
};

/** Open the EEPROM of an encoder with `model`, which must outlive it. `image` has path, say and
 * writer. @return 0, or -1 with one line in `error` */
int lx_biss_memory_open(struct lx_biss_memory *self, const struct dg_biss_model *model,
                        const struct lx_image_setup *image, struct lx_error *error);

/** Make `device` and switch it on at `now`. @return 0, or -1 with one line in `error` */
int lx_biss_switch_on(struct dg_biss *device, const struct dg_biss_setup *setup, dg_ns now,
                      struct lx_error *error);

#endif
