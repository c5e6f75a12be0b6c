/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The models: which stack, which figures, which identity. Each family of models is an object file
 * of its own, so that a program which names one device links the stack of that one only; dg_devices
 * and dg_device_find() link them all.
 */
#ifndef DREHGEBER_DEVICES_H
#define DREHGEBER_DEVICES_H

#include <stddef.h>

#include "drehgeber/api.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

/** RS485 + SinCos: singleturn, multiturn. */
DG_API extern const struct dg_device dg_s3674_rs485, dg_s3684_rs485;
/** BiSS-C: singleturn, multiturn. */
DG_API extern const struct dg_device dg_s3674_biss, dg_s3684_biss;
/** SSI: singleturn, multiturn; multiturn in binary with error bit and parity. */
DG_API extern const struct dg_device dg_ssi_13, dg_ssi_25, dg_ssi_28;
/** CANopen: singleturn, multiturn. */
DG_API extern const struct dg_device dg_f3658, dg_f3668;
/** INTERBUS, by ENCOM profile. */
DG_API extern const struct dg_device dg_ocd_ib_k1, dg_ocd_ib_k2, dg_ocd_ib_k3;

/** All models, in the order they are listed. */
DG_API extern const struct dg_device *const dg_devices[];
DG_API extern const size_t dg_device_count;

/** The model called `name`, or NULL. */
DG_API const struct dg_device *dg_device_find(const char *name);

#ifdef __cplusplus
}
#endif

#endif
