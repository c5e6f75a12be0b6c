/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: motions in words, and recorded ones. The first byte says which: the rest is what
 * --shaft takes, or a CSV file. What is taken can be evaluated at any time; what is refused has a
 * reason and leaves nothing to free.
 */
#define _GNU_SOURCE
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "csv.h"
#include "drehgeber/hal.h"
#include "fuzz_input.h"
#include "motion_words.h"

#define WORDS_MAX 256u
#define CSV 1u

/* Now and then, also at both ends of time. */
static void turn_shaft(struct dg_motion *motion)
{
    for (unsigned bit = 0; bit < 64; bit += 3) {
        (void)dg_motion_angle(motion, ((dg_ns)1 << bit) - 1u);
    }
    (void)dg_motion_angle(motion, DG_NEVER);
}

static void check_points(const struct dg_motion_point *points, size_t count)
{
    fuzz_must(count > 0 && points != NULL);
    for (size_t i = 1; i < count; i++) {
        fuzz_must(points[i - 1].at < points[i].at);
    }
}

static void take_csv(const uint8_t *bytes, size_t n)
{
    struct lx_error error = {.right = ""};
    struct lx_shaft recording = {.points = NULL};
    struct dg_motion motion = {.kind = DG_MOTION_STANDSTILL};
    FILE *file = n > 0 ? fmemopen((void *)(uintptr_t)bytes, n, "r") : NULL;
    int result = 1;

    if (file == NULL) {
        return;
    }
    struct lx_csv *csv = lx_csv_begin(file, "some.csv", &lx_csv_motion, SIZE_MAX);
    fuzz_must(csv != NULL);
    while (result > 0) {
        result = lx_shaft_read_on(csv, &recording, &error);
    }
    if (result == 0) {
        check_points(recording.points, recording.motion.point_count);
        fuzz_must(dg_motion_set(&motion, &recording.motion) == DG_OK);
        turn_shaft(&motion);
        lx_shaft_free(&recording);
    } else {
        fuzz_must(strncmp(lx_error_line(&error).text, "some.csv", 8) == 0);
    }
    lx_csv_close(csv);
}

static void take_words(const uint8_t *bytes, size_t n)
{
    char text[WORDS_MAX];
    struct lx_error error = {.right = ""};
    struct lx_shaft shaft;

    n = n < sizeof text ? n : sizeof text - 1u;
    memcpy(text, bytes, n);
    text[n] = '\0';
    if (dg_motion_is_file(text)) {
        return; /* of this machine */
    }
    const int result = lx_shaft_parse(&shaft, text, NULL, &error);
    fuzz_must(result == 0 || result == LX_SHAFT_WORDS);
    fuzz_must((result == 0) == (lx_error_line(&error).text[0] == '\0') && shaft.points == NULL);
    if (result == 0) {
        const struct dg_motion wanted = shaft.motion;
        fuzz_must(dg_motion_set(&shaft.motion, &wanted) == DG_OK);
        turn_shaft(&shaft.motion);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    if (n == 0) {
        return 0;
    }
    if ((bytes[0] & CSV) != 0) {
        take_csv(bytes + 1, n - 1);
    } else {
        take_words(bytes + 1, n - 1);
    }
    return 0;
}
