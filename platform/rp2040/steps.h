/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What turns the shaft by wires. All pins are pulled down, PIO1 counts:
 *
 * - a step and direction input, as stepper drives have: pin 14 steps at its rising edges, pin 15
 *   says which way; high is clockwise
 * - with pin 13 at 3.3 V at the start, A and B of an incremental encoder, each edge of which
 * counts: pin 14 is A, pin 15 B; A leads clockwise
 */
#ifndef STEPS_H
#define STEPS_H

#include <stdint.h>

/** Steps of a turn, and edges of one: of 1024 lines. */
#define STEPS_PER_TURN 3200u
#define EDGES_PER_TURN 4096u

/** Pins and PIO, once. @return which of the two it is */
uint32_t steps_start(void);
/** Steps, or edges, since then, modulo 2^32. */
uint32_t steps_count(void);

#endif
