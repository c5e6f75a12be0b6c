/* SPDX-License-Identifier: MIT */
/**
 * @file
 * How the line of an encoder that speaks in characters behaves: part of the settings of each
 * protocol that does, whose struct lx_stack says where it is.
 */
#ifndef DREHGEBER_LINUX_LINE_SETTINGS_H
#define DREHGEBER_LINUX_LINE_SETTINGS_H

#include <stdbool.h>

#include "drehgeber/key.h"
#include "drehgeber/time.h"

/** The settings of one encoder's end of a line. */
struct lx_line_settings {
    bool pace;     /**< requests and replies take the time they take on a line */
    bool any_line; /**< whatever the line is set to is right */
    dg_ns sincos;  /**< sine and cosine in a trace: time between samples; 0: none */
};

/** As delivered. */
extern const struct lx_line_settings lx_line_usual;

/** Words of "line". */
extern const char *const lx_line_own_any[2];

/* clang-format off */
/** Rows for struct lx_stack.own: pace and line; `at` is the offset of struct lx_line_settings. */
#define LX_LINE_KEYS(at)                                                                                                                                        \
    /* name            unit       offset                                            type       places factor   min         max  words     help */              \
    {"pace",            "",        (at) + offsetof(struct lx_line_settings, pace),     DG_KEY_FLAG,   0, 1,            0,          1, dg_key_no_yes, "requests and replies at the speed of the line; 0: at once"}, \
    {"line",            "",        (at) + offsetof(struct lx_line_settings, any_line), DG_KEY_FLAG,   0, 1,            0,          1, lx_line_own_any, "data rate the master must use: the encoder's own, or any"}
/** Of an encoder with sine and cosine. */
#define LX_LINE_SINCOS_KEY(at)                                                                                                                                  \
    {"sincos_us",       "us",      (at) + offsetof(struct lx_line_settings, sincos),   DG_KEY_NS,     0, 1000,         0,    1000000, NULL,     "sine and cosine in a VCD trace: time between samples; 0: none"}
/* clang-format on */

#endif
