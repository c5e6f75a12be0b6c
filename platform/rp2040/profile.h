/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Motions in words, those of SHAFt:PROFile that need no file.
 */
#ifndef PROFILE_H
#define PROFILE_H

#include <stdbool.h>

#include "drehgeber/motion.h"

/** What is understood. */
#define PROFILE_FORMS "a profile is 60RPM, sine:90DEG,2S or ramp:3000RPM,1S[,HOLD]"

/** Such a motion. Numbers have up to three decimals. @return false: it is none of these */
bool profile_read(struct dg_motion *to, const char *text);

#endif
