/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of an RS485 encoder on this port, beside its factory figures and its end of the
 * line.
 */
#ifndef DREHGEBER_LINUX_HF_SETTINGS_H
#define DREHGEBER_LINUX_HF_SETTINGS_H

#include "drehgeber/hiperface.h"
#include "stacks.h"

/** The protocol, as the port knows it. */
extern const struct lx_stack lx_hf_stack;

#endif
