/* SPDX-License-Identifier: MIT */
/* The file of an FMU that has a rig (platform/fmu/fmu.h): what the rig file and those that it names
   say. */
#ifndef DREHGEBER_TOOL_FMU_BUNDLE_H
#define DREHGEBER_TOOL_FMU_BUNDLE_H

#include "fmu_models.h"

/* Add it. @return its name, or NULL with `error` */
const char *fmu_bundle_add(struct fmu_models *models, struct lx_error *error);

#endif
