/* SPDX-License-Identifier: MIT */
/* The EDS file (CiA 306) of a CANopen encoder, from the rows of its dictionary. */
#ifndef DREHGEBER_TOOL_EDS_H
#define DREHGEBER_TOOL_EDS_H

#include <stdio.h>

#include "drehgeber/devices.h"

/* Print it. The same for every run of a version. Errors stay in `to`. */
void eds_print(const struct dg_device *device, FILE *to);

#endif
