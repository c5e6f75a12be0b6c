/* SPDX-License-Identifier: MIT */
/* Encoders of an FMU that are not built in: figures in a token, and files. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fmu_rig.h"

/* A text of a file, and how often it was asked for. */
struct shelf {
    const char *text;
    unsigned asked;
};

static char *read_shelf(void *ctx, const char *name, size_t *n)
{
    struct shelf *shelf = ctx;
    shelf->asked++;
    if (strcmp(name, "D958119E.eds") != 0 && strcmp(name, "D958119E.dcf") != 0) {
        return NULL;
    }
    *n = strlen(shelf->text);
    char *copy = malloc(*n);
    assert_non_null(copy);
    memcpy(copy, shelf->text, *n);
    return copy;
}

/* The sum of the text is part of the name; an encoder that is made stays when all is reset. */
static void a_model_may_be_a_file(void **state)
{
    struct shelf shelf = {"[1000]\nDataType=7\nDefaultValue=0x00010196\n", 0};
    const struct fmu_files files = {.read = read_shelf, .ctx = &shelf};
    (void)state;
    assert_null(fmu_make(TOKEN " =D958119E.eds"));
    assert_null(fmu_make_with(TOKEN " =D958119F.eds", &files));
    assert_null(fmu_make_with(TOKEN " =D958119E.ini", &files));
    assert_int_equal(shelf.asked, 1);
    fmu_free(fmu_make_with(TOKEN " =D958119E.eds", &files));
    assert_int_equal(shelf.asked, 2);
    struct fmu *fmu = fmu_make_with(TOKEN " =D958119E.dcf,node=5", &files);
    assert_non_null(fmu);
    assert_int_equal(shelf.asked, 3);
    assert_int_equal(fmu_reset(fmu), 0);
    assert_int_equal(shelf.asked, 3);
    assert_int_equal(dg_host_medium(fmu_host(fmu, 0)), DG_HOST_MEDIUM_FRAMES);
    fmu_free(fmu);
    shelf.text = "[1000]\nDataType=7\nDefaultValue=0x00020196\n";
    assert_null(fmu_make_with(TOKEN " =D958119E.eds", &files));
}

/* Warning, 20 bits of position, error and check sum: another frame than its base's. */
static void a_model_may_be_a_text(void **state)
{
    struct fmu *fmu = fmu_make(TOKEN " =la:s3674-biss;-registers;st=20;lc=0;frame=WPEC,busy_us=3");
    struct fmu_value value = {.type = FMU_BOOL};
    char text[32];
    (void)state;
    assert_non_null(fmu);
    assert_int_equal(dg_host_get(fmu_host(fmu, 0), "busy_us", text, sizeof text), 5);
    for (int i = 0; i < 2; i++) {
        assert_string_equal(dg_host_model(fmu_host(fmu, 0)), "la");
        assert_int_equal(fmu_start(fmu, 0), 0);
        (void)fmu_step(fmu, 0, 1.0, false);
        assert_int_equal(fmu_get(fmu, VARIABLE(FMU_OUTPUT, FMU_FRAME_BITS), &value), 0);
        assert_int_equal(value.integer, 1 + 20 + 1 + 6);
        assert_int_equal(fmu_reset(fmu), 0);
    }
    fmu_free(fmu);
}

static void what_is_no_model_is_refused(void **state)
{
    static const char *const bad[] = {
        TOKEN " =la",
        TOKEN " =la:",
        TOKEN " =la:f3668",
        TOKEN " =la:la",
        TOKEN " =la:s3674-biss;st=99",
        TOKEN " =la:s3674-biss;st",
        TOKEN " =la:s3674-biss;steps=99",
        TOKEN " =la:s3674-biss;-faults",
        TOKEN " =la:s3674-biss;st=%3",
        TOKEN " =la:s3674-biss;st=32;mt=32;lc=0;frame=PEWC",
        TOKEN " =ssi:ssi-25;-registers",
        TOKEN " =00000000.eds",
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(bad); i++) {
        assert_null(fmu_make(bad[i]));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_model_may_be_a_file),
        cmocka_unit_test(a_model_may_be_a_text),
        cmocka_unit_test(what_is_no_model_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
