/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The models: which stack, which figures, which identity. One row each.
 */
#ifndef DREHGEBER_DEVICES_H
#define DREHGEBER_DEVICES_H

#include <stddef.h>

#include "drehgeber/api.h"
#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Which stack a model runs, and so which of its pointers in struct dg_device is set. */
enum dg_device_stack {
    DG_STACK_HIPERFACE,
    DG_STACK_BISS,
    DG_STACK_CANOPEN,
    DG_STACK_INTERBUS,
};

/** A model as it can be ordered. */
struct dg_device {
    const char *name;       /**< as on the command line, e.g. "s3684-rs485" */
    const char *wire;       /**< what it speaks, e.g. "RS485 + SinCos (HIPERFACE-compatible)" */
    const char *resolution; /**< in words, e.g. "2048 periods x 32 steps, 4096 turns" */
    enum dg_device_stack stack;
    const struct dg_hf_model *hiperface;  /**< for DG_STACK_HIPERFACE */
    const struct dg_biss_model *biss;     /**< for DG_STACK_BISS */
    const struct dg_cia406_model *cia406; /**< for DG_STACK_CANOPEN */
    const struct dg_ib_model *interbus;   /**< for DG_STACK_INTERBUS */
};

/** All models, in the order they are listed. */
DG_API extern const struct dg_device dg_devices[];
DG_API extern const size_t dg_device_count;

/** The model called `name`, or NULL. */
DG_API const struct dg_device *dg_device_find(const char *name);

#ifdef __cplusplus
}
#endif

#endif
