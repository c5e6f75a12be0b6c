/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Steps of a protocol that does not exist (tenbit_steps.c).
 */
#ifndef TESTS_CONFORMANCE_TENBIT_STEPS_H
#define TESTS_CONFORMANCE_TENBIT_STEPS_H

struct cf_device;

/** One bench: not for two at a time. */
const struct cf_device *cf_tenbit(void);

#endif
