/* SPDX-License-Identifier: MIT */
/*
 * Frames that were worked out by hand: where the shaft stands, and what a master clocks in.
 */
#ifndef DREHGEBER_TEST_FRAME_ROW_H
#define DREHGEBER_TEST_FRAME_ROW_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/host_wire.h"

struct frame_row {
    const char *figures; /* of the encoder: words of a section, or the name of a model */
    int64_t quarters;    /* the shaft */
    const char *bits;    /* blanks are for the eye */
    uint32_t turns;
    uint32_t counts;
    const char *bent; /* a quantity of the world; NULL: all are healthy */
    int64_t value;
    bool error;
    bool damaged; /* by the master's check */
};

/* Turn the shaft, bend the world, read a frame at `now`, which is then behind it, and compare. */
void frame_row_check(struct dg_host *host, uint64_t *now, const struct frame_row *row);

/* Read a frame; `now` is behind it afterwards. */
void frame_row_read(struct dg_host *host, uint64_t *now, struct dg_host_frame *frame);

/* It is what the row says. */
void frame_row_compare(const struct dg_host_frame *frame, const struct frame_row *row);

#endif
