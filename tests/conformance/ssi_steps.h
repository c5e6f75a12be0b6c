/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What runs the rows of SSI.
 */
#ifndef TESTS_CONFORMANCE_SSI_STEPS_H
#define TESTS_CONFORMANCE_SSI_STEPS_H

#include "rows.h"

/** The steps of an encoder with SSI (ssi_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_ssi(void);

#endif
