/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "fmu_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/crc.h"

#define BUNDLE_MAX 16384u
#define FMU_PATH_MAX 160u

static struct fmu *run_fmu(struct fmu *fmu)
{
    assert_non_null(fmu);
    fmu_use_events(fmu, true);
    assert_int_equal(fmu_start(fmu, 0), DG_HOST_OK);
    return fmu;
}

struct fmu *fmu_running(const char *token)
{
    return run_fmu(fmu_make(token));
}

/* The only file there is. */
static char *read_bundle(void *ctx, const char *name, size_t *n)
{
    const char *bundle = ctx;

    (void)name;
    *n = strlen(bundle);
    char *copy = malloc(*n + 1u);
    return copy == NULL ? NULL : memcpy(copy, bundle, *n);
}

struct fmu_files fmu_bundle_files(const char *bundle, char token[RIG_TOKEN_MAX])
{
    static char kept[BUNDLE_MAX];
    const size_t n = strlen(bundle);

    assert_true(n < sizeof kept);
    memmove(kept, bundle, n + 1u);
    (void)snprintf(token, RIG_TOKEN_MAX, TOKEN " %08X.rig",
                   (unsigned)dg_crc32(0, (const uint8_t *)kept, n));
    return (struct fmu_files){.read = read_bundle, .ctx = kept};
}

static void name_file(const char *folder, const char *token, char path[FMU_PATH_MAX])
{
    (void)snprintf(path, FMU_PATH_MAX, "%s/%s", folder, strrchr(token, ' ') + 1);
}

void fmu_bundle_write(const char *bundle, char folder[FMU_FOLDER_MAX], char token[RIG_TOKEN_MAX])
{
    char path[FMU_PATH_MAX];

    (void)fmu_bundle_files(bundle, token);
    (void)snprintf(folder, FMU_FOLDER_MAX, "/tmp/fmu_rig.XXXXXX");
    assert_non_null(mkdtemp(folder));
    name_file(folder, token, path);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bundle, 1, strlen(bundle), file), strlen(bundle));
    assert_int_equal(fclose(file), 0);
}

void fmu_bundle_remove(const char *folder, const char *token)
{
    char path[FMU_PATH_MAX];

    name_file(folder, token, path);
    assert_int_equal(remove(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

struct fmu_files fmu_rig_files(const char *text, char token[RIG_TOKEN_MAX])
{
    char bundle[BUNDLE_MAX];

    (void)snprintf(bundle, sizeof bundle, "file %zu rig.ini\n%s", strlen(text), text);
    return fmu_bundle_files(bundle, token);
}

struct fmu *fmu_running_rig(const char *text)
{
    char token[RIG_TOKEN_MAX];
    const struct fmu_files files = fmu_rig_files(text, token);

    return run_fmu(fmu_make_with(token, &files));
}

int64_t fmu_integer(struct fmu *fmu, uint32_t reference)
{
    struct fmu_value value;
    assert_int_equal(fmu_get(fmu, reference, &value), DG_HOST_OK);
    return value.integer;
}

double fmu_real(struct fmu *fmu, uint32_t reference)
{
    struct fmu_value value;
    assert_int_equal(fmu_get(fmu, reference, &value), DG_HOST_OK);
    return value.real;
}
