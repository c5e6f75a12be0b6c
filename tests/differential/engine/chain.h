/* SPDX-License-Identifier: MIT */
/*
 * The master of a chain as a simulated wire has one: 1 MHz, a frame of all encoders by itself each
 * 100 ms from the end of initialisation on, and what BISS:FRAMe? and BISS:REGister ask for.
 */
#ifndef TESTS_DIFFERENTIAL_ENGINE_CHAIN_H
#define TESTS_DIFFERENTIAL_ENGINE_CHAIN_H

#include "drehgeber/biss.h"
#include "drehgeber/rig_engine.h"

/** A master. */
struct chain {
    struct dg_bus *bus;
    dg_ns now; /* of its wire, which may be ahead of the rig's */
    dg_ns due; /* the next frame that it reads by itself */
    dg_ns at;  /* the rig's */
    uint64_t bits[DG_BISS_CHAIN_MAX];
    bool cds;
    bool answered;
    unsigned silent; /* frames without Ack */
};

/** Before the power: the rig's encoders, which are all in one chain, get their port. */
void chain_begin(struct chain *self, struct dg_engine *engine, dg_ns begin);

/** Frames that it reads by itself up to `now`. */
void chain_catch_up(struct chain *self, dg_ns now);

#endif
