/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the port knows of SSI.
 */
#ifndef DREHGEBER_LINUX_SSI_SETTINGS_H
#define DREHGEBER_LINUX_SSI_SETTINGS_H

#include "stacks.h"

struct lx_trace_format;

/** The protocol; its settings are a struct dg_ssi_model. */
extern const struct lx_stack lx_ssi_stack;

/** Its traces. */
extern const struct lx_trace_format lx_trace_ssi;

#endif
