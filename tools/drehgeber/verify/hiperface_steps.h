/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Rows of an S36 with RS485, run for a real encoder.
 */
#ifndef DREHGEBER_VERIFY_HIPERFACE_STEPS_H
#define DREHGEBER_VERIFY_HIPERFACE_STEPS_H

#include "drehgeber/hiperface.h"
#include "rows.h"

/** What the rows of cf_hiperface() are run for. */
struct cf_hiperface_trial {
    const struct dg_hf_model *model; /**< in place of what `given` names; NULL: that */
    bool placed;                     /**< `raw` is where it is, in place of what `given` says */
    int64_t raw;                     /**< position, in counts */
    uint32_t counter;                /**< of 46h */
    int32_t temperature_mdegc;
    uint64_t slack;          /**< each wait takes so much longer */
    struct cf_beside beside; /**< it is asked the same; ops NULL: nobody is */
};

/** Run the rows for this from now on; NULL: for the model that each names, alone. */
void cf_hiperface_try(const struct cf_hiperface_trial *wanted);

#endif
