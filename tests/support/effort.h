/* SPDX-License-Identifier: MIT */
/**
 * @file
 * How much a test tries: little while somebody writes, all of it where nobody waits.
 */
#ifndef TESTS_SUPPORT_EFFORT_H
#define TESTS_SUPPORT_EFFORT_H

#include <stdint.h>

/**
 * A program that includes this header runs twice: as unit.NAME it gets `usual`, as thorough.NAME,
 * which has DREHGEBER_THOROUGH in its environment, `thorough`.
 */
uint32_t effort(uint32_t usual, uint32_t thorough);

#endif
