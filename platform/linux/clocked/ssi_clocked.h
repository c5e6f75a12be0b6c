/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder with SSI on a clocked line (clocked.h). Only one: the interface is point to point.
 */
#ifndef DREHGEBER_LINUX_SSI_CLOCKED_H
#define DREHGEBER_LINUX_SSI_CLOCKED_H

#include "clocked_wire.h"
#include "drehgeber/ssi.h"

/** The protocol, as the port knows it; its settings are a struct dg_ssi_model. */
extern const struct lx_stack lx_ssi_stack;

/** Its part of it. */
extern const struct lx_clocked_protocol lx_clocked_ssi;

/** A line. Not to be moved. */
struct lx_ssi_line {
    struct lx_clocked base;
    /** The word that the master of a simulated wire has read last. */
    struct {
        uint64_t bits;                 /**< right-aligned */
        bool answered;                 /**< data was high in front of it and low behind it */
        struct dg_ssi_counters before; /**< of the encoder */
    } frame;
};

#endif
