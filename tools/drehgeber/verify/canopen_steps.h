/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Rows of an F36x8, run for a real encoder or for one that is made otherwise.
 */
#ifndef DREHGEBER_VERIFY_CANOPEN_STEPS_H
#define DREHGEBER_VERIFY_CANOPEN_STEPS_H

#include "drehgeber/cia406.h"
#include "rows.h"

/** What the rows of cf_canopen() are run for. */
struct cf_canopen_trial {
    const struct dg_device *device; /**< in place of what `given` names; NULL: that */
    bool placed;                    /**< `raw` and `serial` are its own */
    uint32_t raw;                   /**< position of 2160h */
    uint32_t serial;
    uint64_t slack;          /**< each wait takes so much longer */
    struct cf_beside beside; /**< it is asked the same; ops NULL: nobody is */
};

/** Run the rows for this from now on; NULL: for the model that each names, alone. */
void cf_canopen_try(const struct cf_canopen_trial *wanted);

/** From now on `given` makes an encoder of what this returns for the model's own; NULL of it: that
 * cannot be. */
void cf_canopen_make(const struct dg_co_device *(*make)(const struct dg_co_device *device));

#endif
