/* SPDX-License-Identifier: MIT */
/*
 * Steps of a protocol that does not exist, in virtual time; eleven.rows explains them.
 */
#include "eleven_steps.h"

#include <stdlib.h>
#include <string.h>

#include "drehgeber/angle.h"
#include "drehgeber/eleven.h"
#include "rows.h"

static struct bench {
    struct dg_eleven_model model;
    struct dg_world world;
    struct dg_eleven device;
    dg_ns now;
    uint8_t reply[DG_ELEVEN_REPLY];
    size_t length;
} bench;

static dg_angle angle(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return 3 * DG_TURN + DG_TURN / 4;
}

static void keep_reply(void *ctx, const uint8_t *bytes)
{
    struct bench *b = ctx;

    memcpy(b->reply, bytes, sizeof b->reply);
    b->length = sizeof b->reply;
}

static void begin(void *ctx)
{
    struct bench *b = ctx;

    *b = (struct bench){.now = DG_S(1), .model.reaction = DG_US(3)};
    dg_world_init(&b->world);
    b->world.angle = angle;
}

static bool do_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    static const struct dg_eleven_ops ops = {.tx = keep_reply};
    struct bench *b = ctx;
    const struct dg_stack_setup setup = {
        .model = &b->model, .world = &b->world, .port = &ops, .ctx = b};

    (void)n;
    b->model.slot = (uint8_t)strtoul(words[1], NULL, 10);
    return (dg_eleven_stack.init(&b->device, &setup) == DG_OK &&
            dg_eleven_stack.power_on(&b->device, 0) == DG_OK) ||
           cf_fail(report, "no device");
}

static bool do_lost(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    (void)words;
    (void)n;
    (void)report;
    b->world.singleturn_ok = false;
    return true;
}

static bool do_ask(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    size_t want = 0;

    b->length = 0;
    (void)dg_eleven_hear(&b->device, b->now, (uint8_t)strtoul(words[1], NULL, 16), false);
    b->now += DG_US(100);
    (void)dg_eleven_stack.step(&b->device, b->now);
    for (size_t i = 3; i < n; i++, want++) {
        if (want >= b->length || b->reply[want] != strtoul(words[i], NULL, 16)) {
            return cf_fail(report, "byte %zu is not %s", want, words[i]);
        }
    }
    return b->length == want || cf_fail(report, "%zu bytes, not %zu", b->length, want);
}

static bool finish(void *ctx, struct cf_report *report)
{
    (void)ctx;
    (void)report;
    return true;
}

const struct cf_device *cf_eleven(void)
{
    static const struct cf_step steps[] = {
        {"given", do_given, false, 0}, {"lost", do_lost, false, 0}, {"ask", do_ask, true, 0}};
    static const struct cf_device device = {.ctx = &bench,
                                            .begin = begin,
                                            .steps = steps,
                                            .step_count = DG_COUNT(steps),
                                            .finish = finish};
    return &device;
}
