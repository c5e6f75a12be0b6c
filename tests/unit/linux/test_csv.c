/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "csv.h"
#include "drehgeber/hal.h"

#define LENGTH(array) (sizeof(array) / sizeof((array)[0]))

static int read_text(struct lx_recording *out, const char *text, struct lx_error *error)
{
    FILE *file = fmemopen(NULL, strlen(text) + 1, "w+");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    rewind(file);
    const int result = lx_csv_read(out, file, "shaft.csv", error);
    (void)fclose(file);
    return result;
}

static void points_are_read(void **state)
{
    struct lx_recording recording;
    struct lx_error error;
    (void)state;
    assert_int_equal(read_text(&recording,
                               "time_s,angle_deg\n"
                               "# a comment\n"
                               "0,0\n"
                               "\n"
                               "  0.5 ,\t-90 # half a second\r\n"
                               "1.000000001,720.0000000001\n",
                               &error),
                     0);
    assert_int_equal(recording.count, 3);
    assert_true(recording.points[0].at == 0 && recording.points[0].angle == 0);
    assert_true(recording.points[1].at == DG_MS(500));
    assert_true(recording.points[1].angle == -(DG_TURN / 4));
    assert_true(recording.points[2].at == DG_S(1) + 1);
    assert_true(recording.points[2].angle == 2 * DG_TURN);
    free(recording.points);
}

static void the_last_line_needs_no_end(void **state)
{
    struct lx_recording recording;
    struct lx_error error;
    (void)state;
    assert_int_equal(read_text(&recording, "2,180", &error), 0);
    assert_int_equal(recording.count, 1);
    assert_true(recording.points[0].at == DG_S(2) && recording.points[0].angle == DG_TURN / 2);
    free(recording.points);
}

/* More lines than fit the first allocation; a motion takes them all. */
static void many_points(void **state)
{
    enum { COUNT = 3000 };
    char *text = malloc(COUNT * 24);
    size_t used = 0;
    (void)state;
    assert_non_null(text);
    for (int i = 0; i < COUNT; i++) {
        used += (size_t)snprintf(text + used, 24, "%d,%d\n", i, i * 360);
    }
    struct lx_recording recording;
    struct lx_error error;
    assert_int_equal(read_text(&recording, text, &error), 0);
    assert_int_equal(recording.count, COUNT);
    struct dg_motion motion = {.kind = DG_MOTION_STANDSTILL};
    const struct dg_motion wanted = {
        .kind = DG_MOTION_REPLAY, .points = recording.points, .point_count = recording.count};
    assert_int_equal(dg_motion_set(&motion, &wanted), DG_OK);
    assert_true(dg_motion_angle(&motion, DG_S(2999)) == 2999 * DG_TURN);
    free(recording.points);
    free(text);
}

/* The message names the file, the line and what is wrong with what. */
static void refusals(void **state)
{
    static const struct {
        const char *text;
        const char *where;
        const char *says;
    } rows[] = {
        {"", "shaft.csv:1:", "no points"},
        {"time_s,angle_deg\n", "shaft.csv:2:", "no points"},
        {"# nothing\n\n", "shaft.csv:3:", "no points"},
        {"0,0\n1\n", "shaft.csv:2:", "'1'"},
        {"0;0\n", "shaft.csv:1:", "'0;0'"},
        {"0,0\ntime_s,angle_deg\n", "shaft.csv:2:", "'time_s'"},
        {"head\nhead\n", "shaft.csv:2:", "'head'"},
        {"0,0\n1,2,3\n", "shaft.csv:2:", "'2,3'"},
        {"-1,0\n", "shaft.csv:1:", "'-1'"},
        {"1e0,0\n", "shaft.csv:1:", "'1e0'"},
        {"0,1e0\n", "shaft.csv:1:", "'1e0'"},
        {"0,\n", "shaft.csv:1:", "''"},
        {"0,0\n# x\n0,1\n", "shaft.csv:3:", "later"},
        {"1,0\n0.9,1\n", "shaft.csv:2:", "later"},
        {"0.0000000001,0\n0.0000000002,0\n", "shaft.csv:2:", "later"},
        {"9000000001,0\n", "shaft.csv:1:", "9000000001"},
        {"0,6000000001\n", "shaft.csv:1:", "6000000001"},
    };
    (void)state;
    for (size_t i = 0; i < LENGTH(rows); i++) {
        struct lx_recording recording;
        struct lx_error error = {.right = ""};
        assert_int_equal(read_text(&recording, rows[i].text, &error), -1);
        const struct lx_words line = lx_error_line(&error);
        assert_ptr_equal(strstr(line.text, rows[i].where), line.text);
        assert_non_null(strstr(line.text, rows[i].says));
        assert_null(strchr(line.text, '\n'));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_read),
        cmocka_unit_test(the_last_line_needs_no_end),
        cmocka_unit_test(many_points),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
