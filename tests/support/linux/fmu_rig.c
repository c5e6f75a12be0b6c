/* SPDX-License-Identifier: MIT */
#include "fmu_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

struct fmu *fmu_running(const char *token)
{
    struct fmu *fmu = fmu_make(token);
    assert_non_null(fmu);
    fmu_use_events(fmu, true);
    assert_int_equal(fmu_start(fmu, 0), DG_HOST_OK);
    return fmu;
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
