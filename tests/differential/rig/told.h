/* SPDX-License-Identifier: MIT */
/* What the encoders of a rig have sent, as lines in front of an answer; main.c has their forms. */
#ifndef TESTS_DIFFERENTIAL_TOLD_H
#define TESTS_DIFFERENTIAL_TOLD_H

#include <stdbool.h>

#include "drehgeber/tap.h"

/** A master clocks a frame that somebody wants the levels of. */
extern bool told_levels;

/** A line of it, if it is ours or such a level; `ctx` is nobody's. */
void told_print(void *ctx, const struct dg_tap_event *event);

#endif
