/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the firmware is a node of: the F3668 (canopen_f3668.c), or its dictionary without the
 * profile (canopen_plain.c).
 */
#ifndef BENCH_SIZE_CANOPEN_DEVICE_H
#define BENCH_SIZE_CANOPEN_DEVICE_H

#include "drehgeber/canopen.h"

extern const struct dg_co_device *const device;
/** Make what is behind the node. @return dg_co_setup.application */
void *device_start(void);

#endif
