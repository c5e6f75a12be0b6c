/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for the control plane: an encoder of every kind on two shafts (the second one geared
 * 1:2 to the first), a session, and a host that remembers what it was asked for.
 */
#ifndef TESTS_SUPPORT_CONTROL_RIG_H
#define TESTS_SUPPORT_CONTROL_RIG_H

#include "biss_rig.h"
#include "co_rig.h"
#include "drehgeber/control.h"
#include "drehgeber/quantity.h"
#include "hf_rig.h"
#include "ib_rig.h"

#define CONTROL_RIG_ENCODERS 5u
#define CONTROL_RIG_ANSWER_MAX 65536u
#define CONTROL_RIG_POINTS 32u

/** The encoders, in their order: "hf", "biss-1", "can", "k3", "k2"; all but "k2" on shaft "main",
 * that one on "geared". */
enum control_rig_encoder {
    CONTROL_RIG_HF,
    CONTROL_RIG_BISS,
    CONTROL_RIG_CAN,
    CONTROL_RIG_K3,
    CONTROL_RIG_K2,
};

/** A course that is followed. */
struct control_rig_course {
    struct dg_rig_course course;
    struct dg_course_point points[CONTROL_RIG_POINTS];
};

struct control_rig {
    struct hf_rig hf;
    struct biss_rig biss;
    struct co_rig co;
    struct ib_rig k3;
    struct ib_rig k2;
    struct dg_rig_shaft shaft[2];
    struct dg_rig_shaft *shafts[2];
    struct dg_encoder encoder[CONTROL_RIG_ENCODERS];
    struct dg_encoder *encoders[CONTROL_RIG_ENCODERS];
    struct dg_rig_ops ops; /**< all of them; may be set to NULL */
    struct control_rig_course courses[CONTROL_RIG_ENCODERS][DG_QUANTITY_COUNT];
    struct dg_rig rig;
    struct dg_control control;
    dg_ns now;

    /* what the host was asked for last */
    unsigned changes; /**< calls of changed(); counted up */
    const struct dg_encoder *changed;
    const char *call;   /**< name of the operation */
    const void *whom;   /**< shaft or encoder */
    char text[600];     /**< path or profile; "NULL". A file of a course has two points: the least
                             at once, and the most in a second */
    int64_t number[4];  /**< interval, permille, span, address, n */
    uint8_t bytes[64];  /**< written to registers, or to be read from them */
    int result;         /**< what operations give */
    uint64_t frame;     /**< what biss_frame() gives */
    uint8_t frame_bits; /**< likewise */
    unsigned lines;     /**< frames that last() has */

    size_t length;
    char answer[CONTROL_RIG_ANSWER_MAX]; /**< since the last line that was sent */
};

/** Everything powered on at 1 s, the shafts at rest. */
void control_rig_start(struct control_rig *self);

/** Send a line at the rig's `now`. @return what came back, without the last line end */
const char *control_rig_say(struct control_rig *self, const char *line);

/** A line with this answer, and no error (cmocka assertions). */
void control_rig_expect(struct control_rig *self, const char *line, const char *answer);

/** A line without an answer whose only error this is, e.g. "-222"; the error's text or NULL. */
void control_rig_refuse(struct control_rig *self, const char *line, const char *error,
                        const char *text);

#endif
