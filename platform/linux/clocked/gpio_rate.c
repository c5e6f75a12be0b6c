/* SPDX-License-Identifier: MIT */
/*
 * Steps of the histogram: below 16 ns one each, then 8 from one power of two to the next, so that
 * what is told is too long by an eighth at most, and never too short.
 */
#include "gpio_rate.h"

#define EDGES_PER_PERIOD ((dg_ns)2)
#define FINE 8u
#define FINE_BITS 3u

/* Bits of `value` beyond those that are told apart; a value has 32 at most. */
static unsigned shift_of(uint32_t value)
{
    unsigned shift = 0;
    while (value >> shift >= 2u * FINE) {
        shift++;
    }
    return shift;
}

static unsigned histogram_step_of(uint32_t value)
{
    const unsigned shift = shift_of(value);
    return (shift << FINE_BITS) + (value >> shift);
}

/* The longest reaction of a step. */
static uint32_t longest(unsigned step)
{
    const unsigned shift = step < 2u * FINE ? 0 : (step >> FINE_BITS) - 1u;
    const uint64_t first = step - (shift << FINE_BITS);
    return (uint32_t)(((first + 1u) << shift) - 1u);
}

void lx_gpio_rate_init(struct lx_gpio_rate *self, uint32_t edges_per_frame)
{
    *self = (struct lx_gpio_rate){.edges_per_frame = edges_per_frame};
}

void lx_gpio_rate_take(struct lx_gpio_rate *self, dg_ns reaction, uint32_t edges)
{
    const uint32_t ns = reaction < UINT32_MAX ? (uint32_t)reaction : UINT32_MAX;
    self->worst_ns = ns > self->worst_ns ? ns : self->worst_ns;
    self->edges += edges;
    self->step[histogram_step_of(ns)] += edges;
}

uint64_t lx_gpio_rate_frames(const struct lx_gpio_rate *self)
{
    return self->edges / self->edges_per_frame;
}

bool lx_gpio_rate_known(const struct lx_gpio_rate *self)
{
    return lx_gpio_rate_frames(self) >= LX_GPIO_RATE_ENOUGH;
}

/* Whether frames with `late` late edges among them are 99.9 % in time: of what is rare, as much
   again and three more may come another time (the bound of 95 % is below that for every number). */
static bool good_enough(const struct lx_gpio_rate *self, uint64_t late)
{
    return (2u * late + 3u) * LX_GPIO_RATE_FRAMES <= lx_gpio_rate_frames(self);
}

uint32_t lx_gpio_rate_reaction_ns(const struct lx_gpio_rate *self)
{
    uint64_t late = 0;
    unsigned step = LX_GPIO_RATE_STEPS;

    while (step > 0 && good_enough(self, late + self->step[step - 1u])) {
        late += self->step[--step];
    }
    if (step == 0 || longest(step - 1u) > self->worst_ns) {
        return self->worst_ns;
    }
    return longest(step - 1u);
}

uint32_t lx_gpio_rate_hz(const struct lx_gpio_rate *self)
{
    const dg_ns half = (dg_ns)lx_gpio_rate_reaction_ns(self) + 1u;

    return self->edges == 0 ? 0 : (uint32_t)(DG_S(1) / (EDGES_PER_PERIOD * half));
}
