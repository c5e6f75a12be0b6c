/* SPDX-License-Identifier: MIT */
/**
 * @file
 * BiSS encoders on a clocked line (clocked.h): a daisy chain. The clock is MA, data is SLO, the
 * master's SL.
 */
#ifndef DREHGEBER_LINUX_BISS_CLOCKED_H
#define DREHGEBER_LINUX_BISS_CLOCKED_H

#include "stacks.h"

/** The protocol, as the port knows it; its settings are a struct dg_biss_model. */
extern const struct lx_stack lx_biss_stack;

#endif
