/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <errno.h>
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

/* The points of a motion. */
struct recording {
    struct dg_motion_point *points; /* owned */
    size_t count;
};

/* All points of `file`, which is closed. @return 0, or -1 with `error` */
static int read_all(struct recording *out, FILE *file, struct lx_error *error)
{
    struct lx_csv *csv = lx_csv_begin(file, "shaft.csv", &lx_csv_motion, SIZE_MAX);
    int result = 1;
    assert_non_null(csv);
    while (result > 0) {
        result = lx_csv_read_on(csv, LX_CSV_SLICE, error);
    }
    if (result == 0) {
        const struct lx_csv_points found = lx_csv_take(csv);
        *out = (struct recording){found.points, found.count};
    }
    lx_csv_close(csv);
    return result;
}

static int read_text(struct recording *out, const char *text, struct lx_error *error)
{
    FILE *file = fmemopen(NULL, strlen(text) + 1, "w+");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    rewind(file);
    return read_all(out, file, error);
}

static void points_are_read(void **state)
{
    struct recording recording;
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
    struct recording recording;
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
    struct recording recording;
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
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct recording recording;
        struct lx_error error = {.right = ""};
        assert_int_equal(read_text(&recording, rows[i].text, &error), -1);
        const struct lx_words line = lx_error_line(&error);
        assert_ptr_equal(strstr(line.text, rows[i].where), line.text);
        assert_non_null(strstr(line.text, rows[i].says));
        assert_null(strchr(line.text, '\n'));
    }
}

/* --- what is no text of lines, or cannot be read --- */

/* A file of any length: what is in it, again and again. It counts what is taken of it. */
struct source {
    const char *text;
    size_t size;
    size_t taken;
    size_t fails_at; /* bytes */
    int reason;      /* why */
};

static ssize_t take_bytes(void *ctx, char *to, size_t n)
{
    struct source *self = ctx;
    size_t done = 0;
    if (self->reason != 0 && self->taken >= self->fails_at) {
        errno = self->reason;
        return -1;
    }
    while (done < n && (self->reason == 0 || self->taken < self->fails_at)) {
        to[done++] = self->text[self->taken++ % self->size];
    }
    return (ssize_t)done;
}

static FILE *open_source(struct source *self)
{
    const cookie_io_functions_t operations = {.read = take_bytes};
    FILE *file = fopencookie(self, "r", operations);
    assert_non_null(file);
    return file;
}

/* @return what is said */
static struct lx_words refusal_of(struct source *self)
{
    struct recording recording;
    struct lx_error error = {.right = ""};
    FILE *file = open_source(self);
    assert_int_equal(read_all(&recording, file, &error), -1);
    return lx_error_line(&error);
}

static void a_file_without_lines_is_not_read_on(void **state)
{
    static const struct source rows[] = {
        {.text = "", .size = 1},   {.text = "1", .size = 1}, {.text = "#", .size = 1},
        {.text = "\r", .size = 1}, {.text = " ", .size = 1}, {.text = "1,2,", .size = 4},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct source source = rows[i];
        assert_string_equal(refusal_of(&source).text,
                            i == 0 ? "shaft.csv:1: no text, as it has a NUL; expected lines of text"
                                   : "shaft.csv:1: more than 198 characters; expected a shorter "
                                     "line of text");
        assert_true(source.taken <= 65536);
    }
}

/* 198 characters and their end, as in a rig file; the last line has none. */
static void lines_have_a_bound(void **state)
{
    static const char *const ends[] = {"", "\n", "\r\n", "\r\n2,3", "\r"};
    char text[512];
    struct recording recording;
    struct lx_error error;
    (void)state;
    for (int n = 197; n <= 199; n++) {
        for (size_t end = 0; end < DG_COUNT(ends); end++) {
            (void)snprintf(text, sizeof text, "0,0\n1,90 #%*s%s", n - 6, "x", ends[end]);
            assert_int_equal(read_text(&recording, text, &error), n <= 198 ? 0 : -1);
            if (n <= 198) {
                assert_int_equal(recording.count, end == 3 ? 3 : 2);
                free(recording.points);
            } else {
                assert_ptr_equal(strstr(error.what, "shaft.csv:2: more than 198"), error.what);
            }
        }
    }
}

static void a_zero_is_no_text(void **state)
{
    struct source source = {.text = "0,0\n1,1 # \0\n2,2\n", .size = 15};
    (void)state;
    assert_non_null(strstr(refusal_of(&source).text, "shaft.csv:2: no text, as it has a NUL"));
}

/* Not the end of the file, wherever it comes. */
static void what_cannot_be_read_is_said(void **state)
{
    static const struct {
        int reason;
        const char *said;
    } rows[] = {
        {EIO, "shaft.csv: cannot read: Input/output error"},
        {ENOMEM, "shaft.csv: cannot read: Cannot allocate memory"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        for (size_t at = 0; at <= 5; at++) {
            struct source source = {.text = "1,2 \n", .size = 5, .reason = rows[i].reason};
            source.fails_at = at;
            assert_string_equal(refusal_of(&source).text, rows[i].said);
        }
    }
}

static void points_have_a_bound(void **state)
{
    (void)state;
    for (size_t most = 2; most <= 3; most++) {
        char text[] = "0,0\n1,0\n\n2,0\n";
        struct lx_error error = {.what = ""};
        FILE *file = fmemopen(text, strlen(text), "r");
        struct lx_csv *csv = lx_csv_begin(file, "shaft.csv", &lx_csv_motion, most);
        assert_non_null(csv);
        assert_int_equal(lx_csv_read_on(csv, 100, &error), most == 3 ? 0 : -1);
        assert_string_equal(error.what, most == 3 ? "" : "shaft.csv:4: more than 2 points");
        lx_csv_close(csv);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_read),
        cmocka_unit_test(the_last_line_needs_no_end),
        cmocka_unit_test(many_points),
        cmocka_unit_test(refusals),
        cmocka_unit_test(a_file_without_lines_is_not_read_on),
        cmocka_unit_test(lines_have_a_bound),
        cmocka_unit_test(a_zero_is_no_text),
        cmocka_unit_test(what_cannot_be_read_is_said),
        cmocka_unit_test(points_have_a_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
