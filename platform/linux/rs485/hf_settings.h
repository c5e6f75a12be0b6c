/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What can be set of an RS485 encoder: its factory figures, and how its line behaves.
 */
#ifndef DREHGEBER_LINUX_HF_SETTINGS_H
#define DREHGEBER_LINUX_HF_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/hiperface.h"
#include "stacks.h"

/** The settings of one encoder. */
struct lx_hf_settings {
    struct dg_hf_settings encoder; /**< factory figures and address */
    bool pace;                     /**< requests and replies take the time they take on a line */
    bool any_line;                 /**< whatever the line is set to is right */
    dg_ns sincos;                  /**< sine and cosine in a trace: time between samples; 0: none */
    bool serial_given;             /**< the serial number was asked for, not left to the model */
};

/** The protocol, as the port knows it. */
extern const struct lx_stack lx_hf_stack;

#endif
