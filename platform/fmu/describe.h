/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The texts of an FMU, which say to an importer what is in it.
 */
#ifndef DREHGEBER_FMU_DESCRIBE_H
#define DREHGEBER_FMU_DESCRIBE_H

#include <stdio.h>

#include "fmu.h"

/** What an FMU is described with. */
struct fmu_about {
    const char *token;
    const char *name;     /**< of the model or the rig */
    char *const *sources; /**< to compile, below sources/ */
    size_t source_count;
};

/** modelDescription.xml of FMI `version`, 2 or 3. `self` is switched on by it. */
void fmu_describe(struct fmu *self, const struct fmu_about *about, int version, FILE *to);
/** terminalsAndIcons/terminalsAndIcons.xml of FMI 3. */
void fmu_describe_terminals(const struct fmu *self, FILE *to);
/** sources/buildDescription.xml of FMI 3. */
void fmu_describe_build(const struct fmu_about *about, FILE *to);
/** extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml */
void fmu_describe_bus(FILE *to);
/** Whether one of them has a CAN bus. */
bool fmu_has_bus(const struct fmu *self);

#endif
