/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder with words of ten bits on a clocked line (clocked.h), and what the port knows of it.
 */
#ifndef DREHGEBER_LINUX_TENBIT_CLOCKED_H
#define DREHGEBER_LINUX_TENBIT_CLOCKED_H

#include "stacks.h"

/** The protocol; its settings are a struct dg_tenbit_model. */
extern const struct lx_stack lx_tenbit_stack;

#endif
