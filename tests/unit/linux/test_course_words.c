/* SPDX-License-Identifier: MIT */
/* Courses in words, and the files they name. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/quantity.h"
#include "motion_words.h"

static int read_course(const char *text, struct dg_course_words *to, struct lx_error *error)
{
    struct dg_plan_error wrong;
    return dg_course_read(text, to, &wrong) == DG_OK ? 0 : lx_error_take(error, &wrong);
}

static void words(void **state)
{
    static const struct {
        const char *text;
        struct dg_course_words is;
    } rows[] = {
        {"a.csv", {5, false, false}},
        {"a.csv,LOOP", {5, true, false}},
        {"../b/warm up.CSV, step , ", {0, false, false}},
        {"../b/warm up.CSV, step,loop", {16, true, true}},
        {"a.csv,once,LINEAR", {5, false, false}},
        {"a.csv,Step", {5, false, true}},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_course_words got;
        struct lx_error error;
        const int result = read_course(rows[i].text, &got, &error);
        assert_true(dg_course_is(rows[i].text));
        assert_int_equal(result, rows[i].is.name == 0 ? -1 : 0);
        if (result == 0) {
            assert_int_equal(got.name, rows[i].is.name);
            assert_int_equal(got.loop, rows[i].is.loop);
            assert_int_equal(got.steps, rows[i].is.steps);
        }
    }
}

static void what_are_none(void **state)
{
    static const struct {
        const char *text;
        bool is;
        const char *said;
    } rows[] = {
        {"85", false, "'85' is no CSV file"},
        {"", false, "'' is no CSV file"},
        {".csv", false, "'.csv' is no CSV file"},
        {"a.csv.old", false, "'a.csv.old' is no CSV file"},
        {"a,b.csv", false, "'a,b.csv' is no CSV file"},
        {"a.csv,", true, "'' is none of the words"},
        {"a.csv,loops", true, "'loops' is none of the words"},
        {"a.csv,loop,lo", true, "'lo' is none of the words"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_course_words got;
        struct lx_error error;
        assert_int_equal(dg_course_is(rows[i].text), rows[i].is);
        assert_int_equal(read_course(rows[i].text, &got, &error), -1);
        assert_string_equal(error.what, rows[i].said);
        assert_string_equal(error.right, "expected " DG_COURSE_FORM);
    }
}

/* @return as lx_csv_read_on() at the end; `found` is the caller's */
static int read_text(const char *text, size_t quantity, struct lx_csv_points *found,
                     struct lx_error *error)
{
    char path[] = "/tmp/course-XXXXXX";
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), strlen(text));
    (void)close(fd);
    struct lx_csv *file = lx_course_open(path, quantity, NULL, error);
    (void)unlink(path);
    assert_non_null(file);
    int result = 1;
    while (result > 0) {
        result = lx_csv_read_on(file, LX_CSV_SLICE, error);
    }
    if (result == 0) {
        *found = lx_csv_take(file);
    }
    lx_csv_close(file);
    return result;
}

static void points_are_read(void **state)
{
    struct lx_csv_points found;
    struct lx_error error;
    (void)state;
    assert_int_equal(read_text("time_s,temperature\n"
                               "0,-12.5\n"
                               "# a step\n"
                               "1.5, 20.1239 # cut\n"
                               "1.5,1000\n",
                               DG_QUANTITY_TEMPERATURE, &found, &error),
                     0);
    const struct dg_course_point *points = found.points;
    assert_int_equal(found.count, 3);
    assert_true(points[0].at == 0 && points[0].value == -12500);
    assert_true(points[1].at == DG_MS(1500) && points[1].value == 20123);
    assert_true(points[2].at == DG_MS(1500) && points[2].value == 1000000);
    free(found.points);
    assert_int_equal(read_text("0,1\n1,0\n", DG_QUANTITY_SINGLETURN, &found, &error), 0);
    assert_int_equal(found.count, 2);
    free(found.points);
}

static void many_points_come_in_slices(void **state)
{
    enum { COUNT = 5000 };
    char *text = malloc(COUNT * 16u);
    struct lx_csv_points found;
    struct lx_error error;
    size_t n = 0;
    (void)state;
    assert_non_null(text);
    for (int i = 0; i < COUNT; i++) {
        n += (size_t)sprintf(text + n, "%d,%d\n", i, i % 2000);
    }
    assert_int_equal(read_text(text, DG_QUANTITY_SIN_AMPLITUDE, &found, &error), 0);
    const struct dg_course_point *points = found.points;
    assert_int_equal(found.count, COUNT);
    for (int i = 0; i < COUNT; i++) {
        assert_true(points[i].at == DG_S(i) && points[i].value == i % 2000);
    }
    free(found.points);
    free(text);
}

static void what_cannot_be_read(void **state)
{
    static const struct {
        const char *text;
        size_t quantity;
        const char *said;
    } rows[] = {
        {"", DG_QUANTITY_SUPPLY, ":1: no points; a line is 'time_s,supply_mv'"},
        {"time_s,x\n1\n", DG_QUANTITY_SUPPLY, ":2: a line is 'time_s,supply_mv', not '1'"},
        {"0,100001\n", DG_QUANTITY_SUPPLY,
         ":1: the value is a number in 0..100000 mV, not '100001'"},
        {"0,-274\n", DG_QUANTITY_TEMPERATURE,
         ":1: the value is a number in -273..1000 degC, not '-274'"},
        {"0,5V\n", DG_QUANTITY_SUPPLY, ":1: the value is a number in 0..100000 mV, not '5V'"},
        {"0,2\n", DG_QUANTITY_SINGLETURN, ":1: the value is 0 or 1, not '2'"},
        {"-1,2\n", DG_QUANTITY_SUPPLY,
         ":1: the time is decimal seconds from 0 to 9000000000, not '-1'"},
        {"1,2\n0.5,2\n", DG_QUANTITY_SUPPLY,
         ":2: the time must not be earlier than on the line before, not '0.5'"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct lx_csv_points found;
        struct lx_error error;
        assert_int_equal(read_text(rows[i].text, rows[i].quantity, &found, &error), -1);
        assert_string_equal(error.what + strlen("/tmp/course-XXXXXX"), rows[i].said);
    }
}

static void a_file_that_is_not_there(void **state)
{
    struct lx_error error;
    (void)state;
    assert_null(lx_course_open("/nowhere/x.csv", DG_QUANTITY_SUPPLY, NULL, &error));
    assert_non_null(strstr(error.what, "/nowhere/x.csv"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words),
        cmocka_unit_test(what_are_none),
        cmocka_unit_test(points_are_read),
        cmocka_unit_test(many_points_come_in_slices),
        cmocka_unit_test(what_cannot_be_read),
        cmocka_unit_test(a_file_that_is_not_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
