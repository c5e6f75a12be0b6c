/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A running rig: shafts, encoders, wires, control plane, traces, from a plan.
 */
#ifndef DREHGEBER_LINUX_RIG_H
#define DREHGEBER_LINUX_RIG_H

#include <systemd/sd-event.h>

#include "bus.h"
#include "drehgeber/control.h"
#include "plan.h"
#include "say.h"

/** How lx_rig_open() ended. */
enum lx_rig_result {
    LX_RIG_OK = 0,
    LX_RIG_PLAN = -1, /**< the plan cannot be: nothing was opened */
    LX_RIG_WORLD = -2 /**< files, wires, sockets: everything is closed again */
};

/** A rig. */
struct lx_rig;

/** What the user wants besides the plan. */
struct lx_rig_setup {
    sd_event *event;
    const struct lx_say *say;
    const struct dg_plan *plan;
    bool verbose; /**< decoded frames on stderr, one line each */
};

/**
 * Bring everything up at `now`, or nothing. Time 0 of all motions is now.
 * @return enum lx_rig_result, with one line in `error`; `*self` is NULL unless it is LX_RIG_OK
 */
int lx_rig_open(struct lx_rig **self, const struct lx_rig_setup *setup, dg_ns now,
                struct lx_error *error);

/** What the master of its wire reads of encoder `index` now, in one line, where that master is in
 * this program. @return false: it does not answer */
bool lx_rig_read(struct lx_rig *self, size_t index, char *text, size_t size);

/** From when on that has something to say; DG_NEVER: it never has, the master is somewhere else. */
dg_ns lx_rig_readable(const struct lx_rig *self, size_t index);

/** Print the ready lines: one for each encoder (without its name for a rig from the command line,
 * and one for a whole ring then), "control ADDRESS" for each address that was asked for, and for a
 * rig file "ready rig".
 * @return 0, or -1 with one line in `error` */
int lx_rig_announce(struct lx_rig *self, struct lx_error *error);

/** Whether the rig of this plan has the time of a simulation that it takes part in; then virtual
 * time is to begin before it is opened. @return 0 with `is`, or -1 with `error` */
int lx_rig_is_stepped(const struct dg_plan *plan, bool *is, struct lx_error *error);

/** Such a rig ends when the step at `span` is done, 0: when others end. */
void lx_rig_end_after(struct lx_rig *self, dg_ns span);

/** Such a rig: do one thing of the present step. @return false: wait for the loop to be woken */
bool lx_rig_step(struct lx_rig *self);

/** Take everything down; NULL is fine. @return 0, or -1 with one line in `error`: a trace or a
 * recording is not whole */
int lx_rig_close(struct lx_rig *self, struct lx_error *error);

#endif
