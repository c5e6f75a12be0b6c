/* SPDX-License-Identifier: MIT */
/* Angles of shafts for angles.py, which puts the questions into memory and reads the answers. */
#include <stdint.h>

#include "drehgeber/hal.h"
#include "drehgeber/shaft.h"

#define QUESTIONS 1000u

/* angles.py has the same. */
struct question {
    uint64_t time; /* accel, or period */
    uint64_t hold;
    uint64_t now;
    int64_t from;
    int64_t amplitude;
    int64_t angle; /* the answer */
    int32_t mrpm;
    uint32_t kind; /* enum dg_motion_kind, or DG_MOTION_KIND_COUNT: steered to `mrpm` */
};

extern struct question questions[QUESTIONS];
struct question questions[QUESTIONS];

static int ask(struct question *question)
{
    const struct dg_motion motion = {.kind = (enum dg_motion_kind)question->kind,
                                     .from = question->from,
                                     .mrpm = question->mrpm,
                                     .accel = question->time,
                                     .hold = question->hold,
                                     .amplitude = question->amplitude,
                                     .period = question->time};
    struct dg_shaft shaft;
    int result;

    dg_shaft_init(&shaft);
    if (motion.kind != DG_MOTION_KIND_COUNT) {
        result = dg_shaft_play(&shaft, 0, &motion);
    } else {
        (void)dg_shaft_set_position(&shaft, 0, motion.from);
        result = dg_shaft_set_velocity(&shaft, 0, motion.mrpm);
    }
    question->angle = dg_shaft_angle(&shaft, question->now);
    return result;
}

int main(void)
{
    for (unsigned i = 0; i < QUESTIONS; i++) {
        if (ask(&questions[i]) != DG_OK) {
            return (int)i + 1;
        }
    }
    return 0;
}
