/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders of an FMU that run, for tests below FMI.
 */
#ifndef TESTS_SUPPORT_FMU_RIG_H
#define TESTS_SUPPORT_FMU_RIG_H

#include "drehgeber/version.h"
#include "fmu.h"

/** What a token begins with; encoders follow. */
#define TOKEN "drehgeber " DG_VERSION
/** The number of a variable of the first encoder. */
#define VARIABLE(group, index) ((uint32_t)(group) << 8 | (uint32_t)(index))

/** With power at 0 s, for an importer that knows events; not NULL. */
struct fmu *fmu_running(const char *token);

/** A variable that can be read. */
int64_t fmu_integer(struct fmu *fmu, uint32_t reference);
double fmu_real(struct fmu *fmu, uint32_t reference);

#endif
