/* SPDX-License-Identifier: MIT */
/*
 * Models of an FMU that are not built in: the figures of a text stand in its token, and an EDS file
 * becomes one of its files (platform/fmu/fmu.h).
 */
#ifndef DREHGEBER_TOOL_FMU_MODELS_H
#define DREHGEBER_TOOL_FMU_MODELS_H

#include <stdio.h>

#include "drehgeber/rig.h"
#include "error.h"
#include "fmu.h"
#include "options.h"

/* A file of the FMU. */
struct fmu_resource {
    char name[40];
    char *bytes; /* owned */
    size_t n;
};

/* Those of one FMU. */
struct fmu_models {
    const struct options *options; /* where models come from */
    const struct dg_plan *plan;
    struct fmu_resource *resources; /* owned */
    size_t count;
    struct fmu_files files; /* the same for fmu_make_with() */
};

void fmu_models_begin(struct fmu_models *self, const struct options *options,
                      const struct dg_plan *plan);
void fmu_models_end(struct fmu_models *self);

/* A file of the FMU, "KIND" behind the check sum that it is called by; once, whoever has it.
   @return its name, or NULL without memory */
const char *fmu_models_add(struct fmu_models *self, const char *kind, const char *text, size_t n);

/* MODEL of a token. @return 0, or -1 with `error` */
int fmu_models_put(struct fmu_models *self, const struct dg_device *model, FILE *to,
                   struct lx_error *error);

/* What is no letter, digit, '.', '_' or '-' as %XX. */
void fmu_put_escaped(const char *text, FILE *to);

#endif
