/* SPDX-License-Identifier: MIT */
/**
 * @file
 * How fast a clock the host can follow, measured on its latest answers. No I/O.
 */
#ifndef DREHGEBER_LINUX_GPIO_RATE_H
#define DREHGEBER_LINUX_GPIO_RATE_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/time.h"

/** Answers that are looked at. */
#define LX_GPIO_RATE_SAMPLES 256u

/** The latest answers. */
struct lx_gpio_rate {
    uint32_t reaction_ns[LX_GPIO_RATE_SAMPLES]; /**< a ring */
    uint32_t count; /**< of answers so far; at least SAMPLES once it was */
};

/** An answer took this long, at most UINT32_MAX. */
void lx_gpio_rate_take(struct lx_gpio_rate *self, dg_ns reaction);

/** Enough answers for a figure that can be told. */
bool lx_gpio_rate_known(const struct lx_gpio_rate *self);

/** 99 % of the answers took no longer; 0 without answers. */
uint32_t lx_gpio_rate_reaction_ns(const struct lx_gpio_rate *self);

/** The clock whose half period that is, so that a master may look at SLO at either edge; 0 without
 * answers. */
uint32_t lx_gpio_rate_hz(const struct lx_gpio_rate *self);

#endif
