/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder with SSI on a clocked line (clocked.h). Only one: the interface is point to point.
 */
#ifndef DREHGEBER_LINUX_SSI_CLOCKED_H
#define DREHGEBER_LINUX_SSI_CLOCKED_H

#include "stacks.h"

/** The protocol, as the port knows it; its settings are a struct dg_ssi_model. */
extern const struct lx_stack lx_ssi_stack;

#endif
