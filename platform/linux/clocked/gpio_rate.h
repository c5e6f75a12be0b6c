/* SPDX-License-Identifier: MIT */
/**
 * @file
 * How fast a clock the host can follow, by all its answers so far. No I/O.
 *
 * An answer is in time when data is set within half a period of its rising edge, so that a master
 * may look at it at either edge; a frame when all its answers are. A frame of n edges is late with
 * a probability of at most n times that of an edge, however late edges come together, and an edge
 * finds the host busy as often at one clock as at another: so the edges of any clock tell the
 * frames of another one. The reaction is counted from the kernel's time of the edge. What was
 * before it, from the line to the kernel's time stamp, nobody in user space can know.
 */
#ifndef DREHGEBER_LINUX_GPIO_RATE_H
#define DREHGEBER_LINUX_GPIO_RATE_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/time.h"

/** Of so many frames one may be late: 99.9 % are in time. */
#define LX_GPIO_RATE_FRAMES 1000u
/** Frames without which nothing is known of 99.9 %: if 1 in LX_GPIO_RATE_FRAMES were late, none of
 * these would be with a probability of 5 % only. */
#define LX_GPIO_RATE_ENOUGH 3000u
/** Reactions are counted in this many steps, 8 from one power of two to the next, up to
 * UINT32_MAX ns. */
#define LX_GPIO_RATE_STEPS 240u

/** All answers so far. */
struct lx_gpio_rate {
    uint32_t edges_per_frame; /**< rising ones of the clock */
    uint32_t worst_ns;        /**< the longest reaction */
    uint64_t edges;
    uint64_t step[LX_GPIO_RATE_STEPS]; /**< edges by their reaction */
};

/** No answers; `edges_per_frame` is at least 1. */
void lx_gpio_rate_init(struct lx_gpio_rate *self, uint32_t edges_per_frame);

/** Answers to `edges` rising edges; the first of them took this long, at most UINT32_MAX. */
void lx_gpio_rate_take(struct lx_gpio_rate *self, dg_ns reaction, uint32_t edges);

/** Whole frames that these edges make. */
uint64_t lx_gpio_rate_frames(const struct lx_gpio_rate *self);

/** Whether 99.9 % of frames are known: LX_GPIO_RATE_ENOUGH were seen. */
bool lx_gpio_rate_known(const struct lx_gpio_rate *self);

/** The reaction that 99.9 % of frames keep to. As long as that is not known: the longest one so
 * far; 0 without any. */
uint32_t lx_gpio_rate_reaction_ns(const struct lx_gpio_rate *self);

/** The clock whose half period is just longer than that; 0 without answers. */
uint32_t lx_gpio_rate_hz(const struct lx_gpio_rate *self);

#endif
