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

/** Longest token of a rig, with its zero. */
#define RIG_TOKEN_MAX 64u

/** The token of an FMU whose rig file is `text`. @return its file */
struct fmu_files fmu_rig_files(const char *text, char token[RIG_TOKEN_MAX]);
/** The same of all parts of the file. */
struct fmu_files fmu_bundle_files(const char *bundle, char token[RIG_TOKEN_MAX]);
/** Longest name of a folder, with its zero. */
#define FMU_FOLDER_MAX 64u
/** The same as a file in a new folder, for functions of FMI. */
void fmu_bundle_write(const char *bundle, char folder[FMU_FOLDER_MAX], char token[RIG_TOKEN_MAX]);
void fmu_bundle_remove(const char *folder, const char *token);
/** As fmu_running(), of a rig file. */
struct fmu *fmu_running_rig(const char *text);

/** A variable that can be read. */
int64_t fmu_integer(struct fmu *fmu, uint32_t reference);
double fmu_real(struct fmu *fmu, uint32_t reference);

#endif
