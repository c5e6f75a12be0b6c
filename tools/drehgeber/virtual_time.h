/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A rig that lives in virtual time: from deadline to deadline, as fast as the machine can.
 */
#ifndef DREHGEBER_VIRTUAL_TIME_H
#define DREHGEBER_VIRTUAL_TIME_H

#include <systemd/sd-event.h>

#include "error.h"
#include "plan.h"
#include "rig.h"

/** A span such as "2.5S", "500MS", "10MIN" or "1H", above 0 and up to 8760H. @return 0 or -1 */
int virtual_time_span(const char *text, dg_ns *span);

/** Understand what --time says, "virtual:SPAN" or NULL, whether the plan has the time of a
 * simulation, and whether it can: all other wires are made by this process.
 * @return 0 with `span` (0: none) and `stepped`, or -1 with `error` */
int virtual_time_of(const char *text, const struct dg_plan *plan, dg_ns *span, bool *stepped,
                    struct lx_error *error);

/** Let it live. @return as sd_event_loop(), 0 when `span` is over */
int virtual_time_loop(sd_event *event, dg_ns span);

/** The same, of a rig whose simulation says how far time goes. @return as sd_event_loop() */
int virtual_time_steps(sd_event *event, struct lx_rig *rig);

#endif
