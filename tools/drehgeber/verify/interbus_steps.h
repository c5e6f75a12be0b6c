/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Rows of an OCD with INTERBUS, run for a real encoder.
 */
#ifndef DREHGEBER_VERIFY_INTERBUS_STEPS_H
#define DREHGEBER_VERIFY_INTERBUS_STEPS_H

#include "drehgeber/interbus.h"
#include "rows.h"

/** A word of a device that is no data but says what it is: its ID word, for struct cf_unit. */
#define CF_INTERBUS_ID 1u

/**
 * What the rows of cf_interbus() are run for. Beside them, a request is OUT, four bytes with the
 * most significant first. An answer is IN, likewise, or with CF_INTERBUS_ID two bytes of the ID
 * word.
 */
struct cf_interbus_trial {
    const struct dg_ib_model *model; /**< in place of one of its profile that `given` names, which
                                          otherwise fails; NULL: what it names */
    bool placed; /**< `raw`, serial number and version are its own, in place of what `given` says */
    int64_t raw; /**< position of the discs, in counts */
    uint64_t slack;          /**< ns that each OUT, and each wait, takes longer */
    struct cf_beside beside; /**< it is asked the same; ops NULL: nobody is */
};

/** Run the rows for this from now on; NULL: for the model that each names, alone. */
void cf_interbus_try(const struct cf_interbus_trial *wanted);

#endif
