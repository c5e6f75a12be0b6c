/* SPDX-License-Identifier: MIT */
/**
 * @file
 * EEPROMs of models that are texts: which figures of another one an image has, in words.
 */
#ifndef DREHGEBER_LINUX_FIGURES_H
#define DREHGEBER_LINUX_FIGURES_H

#include <stdbool.h>

#include "drehgeber/stamp.h"
#include "error.h"

/** Append how an image, which is a copy, differs from one of the model: "st: 25, expected 26".
 * @return false: it is the model's, or of no model of its protocol */
bool lx_figures_differ(const struct dg_model_stamp *model, struct dg_nvm image,
                       struct lx_words *to);

#endif
