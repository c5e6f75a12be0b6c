/* SPDX-License-Identifier: MIT */
/*
 * A model that is asked what a recording has: two of it live the same life. The probe's shaft is
 * somewhere else at each request, so that what it answers shows where in an answer the position is;
 * there the position of the recording is read, and the model's shaft is put to it before the model
 * answers the same request:
 *
 *   request   -> probe  at 5A1F3h   -> 40 42 00 05 A1 F3 ..     the position is at byte 2, MSB
 * first recording                          40 42 00 01 23 45 67     12345h request   -> model  at
 * 12345h   -> 40 42 00 01 23 45 67     no difference
 */
#ifndef DREHGEBER_TOOL_EXPLAIN_MODEL_H
#define DREHGEBER_TOOL_EXPLAIN_MODEL_H

#include "drehgeber/host.h"
#include "drehgeber/time.h"
#include "options.h"

/* They are on since the moment 0, and ready at this one, at which a recording begins. */
#define EXPLAIN_BEGIN DG_S(2)

/* Two encoders of a model. */
struct explain_model {
    struct dg_host *model;
    struct dg_host *probe;
    unsigned bits; /* of positions; 0: it tells none */
    uint32_t turn; /* counts in a 64th of a turn */
    uint32_t seed; /* of where the probe is */
};

/* With the settings of the command line. @return 0, or -1 with `error` */
int explain_model_make(struct explain_model *self, const struct options *options,
                       struct lx_error *error);

/* NULL members are fine. */
void explain_model_free(struct explain_model *self);

/* Put the probe somewhere else, turning or at rest. */
void explain_model_move(struct explain_model *self, dg_ns now, bool turning);

/* Put the shaft of the model to where its position is `counts`. @return whether it can be there */
bool explain_model_place(struct explain_model *self, dg_ns now, uint64_t counts);

/* A setting that tells encoders apart on a wire. @return 0: it has none */
uint32_t explain_model_address(const struct explain_model *self);

#endif
