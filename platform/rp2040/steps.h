/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A step and direction input, as stepper drives have: pin 14 steps at its rising edges, pin 15 says
 * which way; high is clockwise. Both are pulled down. PIO1 counts.
 */
#ifndef STEPS_H
#define STEPS_H

#include <stdint.h>

/** Steps of a turn. */
#define STEPS_PER_TURN 3200

/** Pins and PIO, once. */
void steps_start(void);
/** Steps since then, modulo 2^32. */
uint32_t steps_count(void);

#endif
