/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of an RS485 encoder: its factory figures, and how its line behaves.
 */
#ifndef DREHGEBER_LINUX_HF_SETTINGS_H
#define DREHGEBER_LINUX_HF_SETTINGS_H

#include "drehgeber/hiperface.h"
#include "line_settings.h"
#include "stacks.h"

/** The settings of one encoder. */
struct lx_hf_settings {
    struct dg_hf_settings encoder; /**< factory figures and address */
    struct lx_line_settings line;
};

/** The protocol, as the port knows it. */
extern const struct lx_stack lx_hf_stack;

#endif
