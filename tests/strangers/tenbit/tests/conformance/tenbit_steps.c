/* SPDX-License-Identifier: MIT */
/*
 * Steps of a protocol that does not exist, in virtual time; tenbit.rows explains them.
 */
#include "tenbit_steps.h"

#include <stdlib.h>

#include "drehgeber/angle.h"
#include "drehgeber/tenbit.h"
#include "rows.h"

#define HALF 500u

static struct bench {
    struct dg_world world;
    struct dg_tenbit device;
    int64_t counts;
    dg_ns now;
} bench;

static dg_angle angle(void *ctx, dg_ns now)
{
    const struct bench *b = ctx;

    (void)now;
    return b->counts * (DG_TURN >> DG_TENBIT_BITS);
}

static void begin(void *ctx)
{
    struct bench *b = ctx;

    *b = (struct bench){.now = DG_S(1)};
    dg_world_init(&b->world);
    b->world.angle = angle;
    b->world.angle_ctx = b;
}

static bool do_turn(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    (void)n;
    (void)report;
    b->counts = strtol(words[1], NULL, 10);
    return true;
}

static bool do_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const struct dg_stack_setup setup = {.model = dg_tenbit_low.model, .world = &b->world};

    return do_turn(ctx, words, n, report) && ((dg_tenbit_stack.init(&b->device, &setup) == DG_OK &&
                                               dg_tenbit_stack.power_on(&b->device, 0) == DG_OK) ||
                                              cf_fail(report, "no device"));
}

static bool do_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    (void)n;
    (void)report;
    b->now += strtoul(words[1], NULL, 10);
    return true;
}

static bool do_clock(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    for (size_t i = 2; i < n; i++) {
        for (size_t k = 0; words[i][k] != '\0'; k++) {
            (void)dg_tenbit_clock(&b->device, b->now, false);
            const bool bit = dg_tenbit_clock(&b->device, b->now + HALF, true);
            b->now += 2u * HALF;
            if (bit != (words[i][k] == '1')) {
                return cf_fail(report, "bit %zu of %s is %d", k, words[i], bit);
            }
        }
    }
    return true;
}

static bool finish(void *ctx, struct cf_report *report)
{
    (void)ctx;
    (void)report;
    return true;
}

const struct cf_device *cf_tenbit(void)
{
    static const struct cf_step steps[] = {{"given", do_given, false, 0},
                                           {"turn", do_turn, false, 0},
                                           {"wait", do_wait, false, 0},
                                           {"clock", do_clock, true, 0}};
    static const struct cf_device device = {.ctx = &bench,
                                            .begin = begin,
                                            .steps = steps,
                                            .step_count = DG_COUNT(steps),
                                            .finish = finish};
    return &device;
}
