/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Rows of an S36 with BiSS, run for a real encoder.
 */
#ifndef DREHGEBER_VERIFY_BISS_STEPS_H
#define DREHGEBER_VERIFY_BISS_STEPS_H

#include "biss_master.h"
#include "drehgeber/biss.h"
#include "rows.h"

/** Most frames of a step. */
#define CF_BISS_FRAMES_MAX 1000u

/** What a unit is; its bytes are a struct, which says what is asked and, of an answer, what came. */
enum cf_biss_kind {
    CF_BISS_FRAMES = 1, /**< struct cf_biss_frames */
    CF_BISS_ACCESS,     /**< struct cf_biss_access */
    CF_BISS_COMMAND     /**< struct biss_command */
};

/** Frames, a CDM bit each. */
struct cf_biss_frames {
    char cdm[CF_BISS_FRAMES_MAX + 1u]; /**< '0' and '1', terminated */
    char cds[CF_BISS_FRAMES_MAX + 1u]; /**< what came, likewise */
    char any[CF_BISS_FRAMES_MAX + 1u]; /**< 'x' where the row expects any; may be shorter */
    struct biss_frame last;            /**< the last one */
};

/** Registers. */
struct cf_biss_access {
    struct biss_access access;
    bool stray;   /**< as biss_master.stray */
    bool heard;   /**< a CDS bit was 1 behind the ID locks */
    uint8_t bank; /**< of an answer: that the model had selected when it was asked */
};

/**
 * What the rows of cf_biss() are run for.
 */
struct cf_biss_trial {
    const struct dg_biss_model *model; /**< in place of what `given` names; other figures than its
                                            own fail; NULL: what `given` names */
    bool placed;             /**< `raw` and the serial number are its own, in place of the rows' */
    int64_t raw;             /**< position, in counts, MT and ST */
    uint64_t period_ns;      /**< of the clock; 0: as the row says */
    uint64_t timeout_max;    /**< biss_master.timeout_max; 0: as usual */
    uint64_t frame_ns;       /**< how long a frame takes on the wire */
    uint64_t slack;          /**< each wait takes so much longer */
    struct cf_beside beside; /**< it is asked the same; ops NULL: nobody is */
};

/** Run the rows for this from now on; NULL: for the model that each names, alone. */
void cf_biss_try(const struct cf_biss_trial *wanted);

/** Let `master` clock these frames. */
void cf_biss_clock(struct biss_master *master, struct cf_biss_frames *frames);

/** Let `master` make this access. */
void cf_biss_access(struct biss_master *master, struct cf_biss_access *access);

/** Whether a register has what is the encoder's own: serial number, position, life counter,
 * temperature, revision. */
bool cf_biss_is_own(uint8_t address);

#endif
