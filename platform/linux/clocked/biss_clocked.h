/* SPDX-License-Identifier: MIT */
/**
 * @file
 * BiSS encoders on a clocked line (clocked.h): a daisy chain. The clock is MA, data is SLO, the
 * master's SL.
 */
#ifndef DREHGEBER_LINUX_BISS_CLOCKED_H
#define DREHGEBER_LINUX_BISS_CLOCKED_H

#include "clocked_wire.h"
#include "drehgeber/biss.h"

/** A line. Not to be moved. */
struct lx_biss_line {
    struct lx_clocked base;
    /** The frame that the master of a simulated wire has read last. */
    struct {
        uint64_t bits[LX_CLOCKED_MAX]; /**< behind CDS, right-aligned */
        bool cds;
        bool answered; /**< there was an Ack */
        dg_ns start;   /**< from e1 to the start bit, without the delay of the cable */
    } frame;
};

/** The protocol, as the port knows it; its settings are a struct dg_biss_model. */
extern const struct lx_stack lx_biss_stack;

/** Its part of it. */
extern const struct lx_clocked_protocol lx_clocked_biss;

/** That of `wire`. */
struct lx_biss_line *lx_biss_line_of(const struct lx_clocked_wire *wire);

/** Clock a frame up to the last bit of the last CRC; its CDM bit is not yet decided. @return CDS */
bool lx_biss_frame_begin(struct lx_clocked_wire *wire);

/** End it with this CDM bit, and wait for the timeout. */
void lx_biss_frame_end(struct lx_clocked_wire *wire, bool cdm);

#endif
