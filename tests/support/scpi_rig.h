/* SPDX-License-Identifier: MIT */
/*
 * A host for SCPI sessions: commands of every kind, and what was answered.
 */
#ifndef SCPI_RIG_H
#define SCPI_RIG_H

#include "drehgeber/scpi.h"

#define SCPI_RIG_OUT_MAX 8192u
#define SCPI_RIG_TEXT_SIZE 16u

/* Values that commands set and queries show, by the commands' arguments. */
enum scpi_rig_value {
    SCPI_RIG_POSITION,
    SCPI_RIG_VELOCITY,
    SCPI_RIG_ACCELERATION,
    SCPI_RIG_SPAN,
    SCPI_RIG_TEMPERATURE,
    SCPI_RIG_SUPPLY,
    SCPI_RIG_CURRENT,
    SCPI_RIG_NUMBER,
    SCPI_RIG_BYTE,
    SCPI_RIG_THOUSANDTHS,
    SCPI_RIG_SINE,
    SCPI_RIG_COSINE,
    SCPI_RIG_FLAG,
    SCPI_RIG_VALUES
};

struct scpi_rig {
    struct dg_scpi session;
    int64_t values[SCPI_RIG_VALUES];
    char text[SCPI_RIG_TEXT_SIZE];
    dg_ns settles;   /* what ops->settled says */
    unsigned asked;  /* ... and how often */
    unsigned resets; /* *RST */
    unsigned stops;
    unsigned taken;             /* numbers, flags and strings that were taken */
    char out[SCPI_RIG_OUT_MAX]; /* terminated */
    size_t length;
    bool lost; /* more was answered than fits, or nothing at all */
};

extern const struct dg_scpi_command scpi_rig_commands[];
extern const size_t scpi_rig_command_count;

void scpi_rig_init(struct scpi_rig *self);
/* Everything at once, at time 0; the answer is in self->out. */
void scpi_rig_send(struct scpi_rig *self, const char *text);
void scpi_rig_send_bytes(struct scpi_rig *self, const char *bytes, size_t n);

#endif
