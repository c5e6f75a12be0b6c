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

/** Understand what --time says, "virtual:SPAN", and whether `plan` can: all of its wires are made
 * by this process. @return 0 with `span`, or -1 with `error` */
int virtual_time_span(const char *text, const struct lx_plan *plan, dg_ns *span,
                      struct lx_error *error);

/** Let it live. @return as sd_event_loop(), 0 when `span` is over */
int virtual_time_loop(sd_event *event, dg_ns span);

#endif
