/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Rows of an encoder with SSI, run for a real one.
 */
#ifndef DREHGEBER_VERIFY_SSI_STEPS_H
#define DREHGEBER_VERIFY_SSI_STEPS_H

#include "drehgeber/ssi.h"
#include "rows.h"

/** Most pulses, or edges, of a step. */
#define CF_SSI_BITS_MAX 400u

/** What a unit is; its bytes are a struct cf_ssi_look. */
enum cf_ssi_kind {
    CF_SSI_PULSES = 1, /**< data is looked at before the clock falls again */
    CF_SSI_EDGES,      /**< data is looked at behind each edge */
    CF_SSI_LEVEL       /**< data is looked at after a time without an edge */
};

/** What the clock does, and what came. */
struct cf_ssi_look {
    unsigned pulses;                  /**< CF_SSI_PULSES */
    char clock[CF_SSI_BITS_MAX + 2u]; /**< CF_SSI_EDGES: its levels, '0' and '1', terminated */
    uint64_t wait_ns;                 /**< CF_SSI_LEVEL */
    bool low;                         /**< the clock was low before */
    unsigned phase;                   /**< pulses since the position was stored, before */
    bool rests;                       /**< afterwards nothing happens for the monoflop time */
    char data[CF_SSI_BITS_MAX + 2u];  /**< what came: a level for each look */
};

/** What the rows of cf_ssi() are run for. */
struct cf_ssi_trial {
    const struct dg_ssi_model *model; /**< in place of what `given` names; other figures than its
                                           own fail; NULL: what `given` names */
    bool placed;                      /**< `raw` is where it is, in place of what the row says */
    int64_t raw;                      /**< position, in counts, multiturn and singleturn */
    uint64_t half_ns;                 /**< half a period of the clock; 0: as the row says */
    uint64_t slack;                   /**< each wait takes so much longer */
    struct cf_beside beside;          /**< it is asked the same; ops NULL: nobody is */
};

/** Run the rows for this from now on; NULL: for the model that each names, alone. */
void cf_ssi_try(const struct cf_ssi_trial *wanted);

/** Which bit of the word data is at a look: 0 is the first one, that behind the last one is the 0
 * between words; -1: none yet. */
int cf_ssi_bit(const struct cf_ssi_look *look, const struct dg_ssi_model *model, size_t at);

#endif
