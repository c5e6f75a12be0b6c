/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The models: which stack, which figures, which identity. Each family of models is an object file
 * of its own and declared in the header of its protocol, so that a program which names one device
 * links the stack of that one only; dg_devices and dg_device_find() link them all.
 */
#ifndef DREHGEBER_DEVICES_H
#define DREHGEBER_DEVICES_H

#include <stddef.h>

#include "drehgeber/api.h"
#include "drehgeber/stack.h"

struct dg_model_file; /* model.h, likewise the next */
struct dg_model_text;

#ifdef __cplusplus
extern "C" {
#endif

/** All models, in the order they are listed. */
DG_API extern const struct dg_device *const dg_devices[];
DG_API extern const size_t dg_device_count;

/** The model called `name`, or NULL. */
DG_API const struct dg_device *dg_device_find(const char *name);

/** What a text can say of models of `stack`; NULL: nothing. Links all stacks. */
DG_API const struct dg_model_text *dg_model_text_of(const struct dg_stack *stack);

/** How a model is made of the file called `name`, which goes by its ending; NULL: it is none. */
DG_API const struct dg_model_file *dg_model_file_of(const char *name);

#ifdef __cplusplus
}
#endif

#endif
