/* SPDX-License-Identifier: MIT */
/*
 * The clock that an encoder on GPIO lines says to be good: hosts made up here answer in virtual
 * time, first while they are measured, then to a master with the clock that was told.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "effort.h"
#include "gpio_rate.h"

#define FRAMES_REPLAYED 20000u
#define LATE_MAX (FRAMES_REPLAYED / 1000u)
#define EDGES_S3674 39u
#define EDGES_S3684 51u
/* Ends a frame; the host goes on meanwhile. */
#define PAUSE DG_MS(25)
#define STALL_EVERY DG_MS(400)

/* A host. */
struct host {
    dg_ns (*reaction)(struct host *self, dg_ns at);
    uint32_t noise;
    dg_ns stall; /* the latest one begins */
    dg_ns stall_end;
};

static uint32_t draw(struct host *self, uint32_t n)
{
    self->noise = self->noise * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)self->noise * n >> 32);
}

static dg_ns steady(struct host *self, dg_ns at)
{
    (void)self;
    (void)at;
    return DG_US(100);
}

/* One edge of 5000 takes 3 ms: 1 % of the frames of a s3684. */
static dg_ns with_outliers(struct host *self, dg_ns at)
{
    (void)at;
    return draw(self, 5000) == 0 ? DG_MS(3) : DG_US(50) + draw(self, 50000);
}

/* One of 200 000 is so rare that 99.9 % of the frames have none. */
static dg_ns with_rare_outliers(struct host *self, dg_ns at)
{
    (void)at;
    return draw(self, 200000) == 0 ? DG_MS(10) : DG_US(50) + draw(self, 50000);
}

/* Half of the edges take 20 us or more, a quarter 40 us, an eighth 80 us, ... */
static dg_ns with_a_long_tail(struct host *self, dg_ns at)
{
    dg_ns reaction = DG_US(20);
    (void)at;
    for (unsigned i = 0; i < 14 && draw(self, 2) == 0; i++) {
        reaction *= 2u;
    }
    return reaction / 2u + draw(self, (uint32_t)reaction / 2u);
}

/* It stands still for up to 2 ms now and then, and several edges of a fast clock fall into it. */
static dg_ns with_stalls(struct host *self, dg_ns at)
{
    while (self->stall + STALL_EVERY < at) {
        self->stall += STALL_EVERY / 2u + draw(self, (uint32_t)STALL_EVERY);
        self->stall_end = self->stall + draw(self, DG_MS(2));
    }
    const bool stalls = at >= self->stall && at < self->stall_end;
    return DG_US(60) + (stalls ? self->stall_end - at : 0u);
}

/* A frame with half periods of `half`, from `at` on. @return the longest reaction */
static dg_ns frame(struct host *host, struct lx_gpio_rate *rate, unsigned edges, dg_ns at,
                   dg_ns half)
{
    dg_ns worst = 0;
    for (unsigned i = 0; i < edges; i++) {
        const dg_ns reaction = host->reaction(host, at + 2u * half * i);
        worst = reaction > worst ? reaction : worst;
        if (rate != NULL) {
            lx_gpio_rate_take(rate, reaction, 1);
        }
    }
    return worst;
}

static void measure(struct lx_gpio_rate *rate, dg_ns (*reaction)(struct host *, dg_ns),
                    unsigned edges, unsigned frames)
{
    struct host host = {.reaction = reaction, .noise = 7};
    const dg_ns half = DG_US(100); /* 5 kHz, for many of them too fast */
    dg_ns at = DG_S(1);
    lx_gpio_rate_init(rate, edges);
    for (unsigned i = 0; i < frames; i++) {
        (void)frame(&host, rate, edges, at, half);
        at += 2u * half * edges + PAUSE;
    }
}

/* @return how many of FRAMES_REPLAYED are late at the clock that was told */
static unsigned replay(const struct lx_gpio_rate *rate, dg_ns (*reaction)(struct host *, dg_ns))
{
    struct host host = {.reaction = reaction, .noise = 4711};
    const uint32_t hz = lx_gpio_rate_hz(rate);
    unsigned late = 0;
    assert_true(hz > 0);
    const dg_ns half = hz == 0 ? 0 : DG_S(1) / ((dg_ns)2 * hz);
    dg_ns at = DG_S(1);
    for (unsigned i = 0; i < FRAMES_REPLAYED; i++) {
        late += frame(&host, NULL, rate->edges_per_frame, at, half) >= half;
        at += 2u * half * rate->edges_per_frame + PAUSE;
    }
    return late;
}

static void the_told_clock_holds_for_999_permille_of_frames(void **state)
{
    static dg_ns (*const hosts[])(struct host *, dg_ns) = {
        steady, with_outliers, with_rare_outliers, with_a_long_tail, with_stalls,
    };
    static const unsigned frames[] = {LX_GPIO_RATE_ENOUGH, 4u * LX_GPIO_RATE_ENOUGH, 30000};
    static const unsigned edges[] = {EDGES_S3674, EDGES_S3684};
    const uint32_t measurements = effort(3, 6); /* the longer ones take their time */
    (void)state;
    for (size_t i = 0; i < DG_COUNT(hosts); i++) {
        for (size_t j = 0; j < measurements; j++) {
            struct lx_gpio_rate rate;
            measure(&rate, hosts[i], edges[j % 2], frames[j / 2]);
            assert_true(lx_gpio_rate_known(&rate));
            assert_in_range(replay(&rate, hosts[i]), 0, LATE_MAX);
        }
    }
}

/* Half a period just longer than the reaction; 99 % of edges would have said 5 kHz to the third. */
static void the_told_clock_is_no_slower_than_needed(void **state)
{
    struct lx_gpio_rate rate;
    (void)state;
    measure(&rate, steady, EDGES_S3674, LX_GPIO_RATE_ENOUGH);
    assert_int_equal(lx_gpio_rate_reaction_ns(&rate), 100000);
    assert_int_equal(lx_gpio_rate_hz(&rate), 4999);
    measure(&rate, with_rare_outliers, EDGES_S3674, 30000);
    assert_int_equal(rate.worst_ns, 10000000);
    /* Up to 99 999; of the 8 steps from 65 536 to 131 072 that is in the one from 98 304 on. */
    assert_int_equal(lx_gpio_rate_reaction_ns(&rate), 106495);
    measure(&rate, with_outliers, EDGES_S3684, 30000);
    assert_int_equal(lx_gpio_rate_hz(&rate), 166);
}

static void before_enough_frames_the_slowest_counts(void **state)
{
    struct lx_gpio_rate rate;
    (void)state;
    lx_gpio_rate_init(&rate, 39);
    assert_int_equal(lx_gpio_rate_hz(&rate), 0);
    assert_int_equal(lx_gpio_rate_frames(&rate), 0);
    lx_gpio_rate_take(&rate, DG_US(50), 38);
    assert_int_equal(lx_gpio_rate_frames(&rate), 0);
    assert_int_equal(lx_gpio_rate_hz(&rate), 9999);
    lx_gpio_rate_take(&rate, DG_US(250), 1);
    assert_int_equal(lx_gpio_rate_frames(&rate), 1);
    assert_int_equal(lx_gpio_rate_reaction_ns(&rate), 250000);
    assert_int_equal(lx_gpio_rate_hz(&rate), 1999);
    lx_gpio_rate_take(&rate, DG_US(50), 2998u * 39u + 38u);
    assert_int_equal(lx_gpio_rate_frames(&rate), 2999);
    assert_false(lx_gpio_rate_known(&rate));
    lx_gpio_rate_take(&rate, DG_US(50), 1);
    assert_true(lx_gpio_rate_known(&rate));
    assert_int_equal(lx_gpio_rate_hz(&rate), 1999); /* one late edge takes 5000 frames */
    lx_gpio_rate_take(&rate, DG_US(50), 1999u * 39u + 38u);
    assert_int_equal(lx_gpio_rate_hz(&rate), 1999);
    lx_gpio_rate_take(&rate, DG_US(50), 1);
    assert_int_equal(lx_gpio_rate_frames(&rate), 5000);
    assert_int_equal(lx_gpio_rate_reaction_ns(&rate), 53247); /* the step from 49 152 on */
}

/* Each reaction falls into a step whose longest is at least as long, and at most an eighth more, as
   there are 8 from one power of two to the next: an encoder cannot know its host's reactions better
   than they repeat. */
static void steps_are_fine_enough(void **state)
{
    (void)state;
    for (uint64_t ns = 1; ns <= UINT32_MAX; ns += 1u + ns / 5u) {
        struct lx_gpio_rate rate;
        lx_gpio_rate_init(&rate, 1);
        lx_gpio_rate_take(&rate, UINT32_MAX, 1); /* far away, and too few to count */
        lx_gpio_rate_take(&rate, ns, 2u * LX_GPIO_RATE_ENOUGH);
        const uint32_t told = lx_gpio_rate_reaction_ns(&rate);
        assert_in_range(told, ns, ns + ns / 8u);
    }
}

static void very_long_reactions(void **state)
{
    struct lx_gpio_rate rate;
    (void)state;
    lx_gpio_rate_init(&rate, 39);
    lx_gpio_rate_take(&rate, DG_S(100), UINT32_MAX);
    lx_gpio_rate_take(&rate, DG_S(100), UINT32_MAX);
    assert_int_equal(lx_gpio_rate_frames(&rate), 2u * (uint64_t)UINT32_MAX / 39u);
    assert_int_equal(lx_gpio_rate_reaction_ns(&rate), UINT32_MAX);
    assert_int_equal(lx_gpio_rate_hz(&rate), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_told_clock_holds_for_999_permille_of_frames),
        cmocka_unit_test(the_told_clock_is_no_slower_than_needed),
        cmocka_unit_test(before_enough_frames_the_slowest_counts),
        cmocka_unit_test(steps_are_fine_enough),
        cmocka_unit_test(very_long_reactions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
