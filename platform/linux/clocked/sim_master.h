/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The master of a simulated wire. What it does, and what the encoders say to it, goes to a tap.
 * What a protocol's master can do besides reading frames is that protocol's file.
 */
#ifndef DREHGEBER_LINUX_SIM_MASTER_H
#define DREHGEBER_LINUX_SIM_MASTER_H

#include "clocked_wire.h"
#include "tap.h"

/** Room for a note: 64 registers. */
#define LX_SIM_NOTE_MAX 240u

/** A master. Not to be moved. */
struct lx_sim_master {
    struct lx_clocked_wire wire;
    const struct lx_tap *tap;
};

/** Of a wire with the encoders of `line`, as lx_clocked_wire_init(). `tap` must outlive it. */
void lx_sim_master_init(struct lx_sim_master *self, const struct lx_tap *tap,
                        struct lx_clocked *line, const struct dg_plan_timing *timing, dg_ns now);

/** Nothing happens until `now`, as lx_clocked_wire_pause(). */
void lx_sim_master_pause(struct lx_sim_master *self, dg_ns now);

/** Read a frame of all encoders, as lx_clocked_protocol.read(). */
void lx_sim_master_frame(struct lx_sim_master *self);

/** Begin a text on an encoder with its name, where there are several. @return how long it is */
int lx_sim_master_name(const struct lx_sim_master *self, size_t encoder, char *text, size_t size);

/** Tell the tap something in words that has just happened. */
void lx_sim_master_note(const struct lx_sim_master *self, const char *text,
                        enum dg_severity severity);

#endif
