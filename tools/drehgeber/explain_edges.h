/* SPDX-License-Identifier: MIT */
/*
 * Frames of a clocked line: what the master sees of the data line when its clock is about to fall.
 * Slaves change it behind the rising edge.
 *
 *   clock  ¯¯|__|¯¯|__|¯¯| ... |¯¯¯¯¯¯¯¯¯¯¯|__     a pause ends the frame
 *   data   ¯¯¯¯¯|  bit   | ...
 *           ^     ^
 */
#ifndef DREHGEBER_TOOL_EXPLAIN_EDGES_H
#define DREHGEBER_TOOL_EXPLAIN_EDGES_H

#include "explain_replay.h"

/* Edges of the clock in a frame; what is longer is another frame. */
#define EXPLAIN_EDGES_MAX 1024u
#define EXPLAIN_BITS_MAX ((size_t)8 * EXPLAIN_BYTES_MAX)

struct explain_frame {
    size_t edges; /* of the clock */
    dg_ns at[EXPLAIN_EDGES_MAX];
    bool level[EXPLAIN_EDGES_MAX];
    size_t count; /* bits, one for each falling edge */
    bool bits[EXPLAIN_BITS_MAX];
};

struct explain_edges {
    struct explain_model *model; /* NULL: nothing is compared */
    struct explain_talk *talk;
    /* A frame, and what the model has; NULL: nothing was compared. */
    void (*frame)(void *ctx, const struct explain_message *message);
    void (*differs)(void *ctx, const struct explain_difference *difference);
    void *ctx;
    bool clock;
    bool data;
    bool begun;
    dg_ns half; /* the shortest time between two edges of the clock */
    dg_ns base; /* of the recording */
    dg_ns slip;
    dg_ns now; /* of the model */
    bool lost; /* counters in frames may be others than those of the recording */
    bool same; /* the last frame was that of the recording */
    uint64_t messages;
    bool levels[2];
    struct explain_frame heard; /* of the recording */
    struct explain_frame said[2];
};

/* Read all. @return 0, or -1 with `error` of the recording */
int explain_edges_run(struct explain_edges *self, struct lx_error *error);

#endif
