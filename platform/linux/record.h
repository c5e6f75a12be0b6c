/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A shaft's motion into a CSV file, which --shaft and SHAFt:PROFile replay.
 */
#ifndef DREHGEBER_LINUX_RECORD_H
#define DREHGEBER_LINUX_RECORD_H

#include <systemd/sd-event.h>

#include "bus.h"
#include "drehgeber/shaft.h"
#include "say.h"

/** A recording. */
struct lx_record;

/**
 * Write "time_s,angle_deg" every `interval` (100 us .. 1 h) from the rig's `now` on, time 0 being
 * now; exact moments of the grid, not of the wake-ups, and angles that read back as the same angle.
 * @return NULL with one line in `error`
 */
struct lx_record *lx_record_open(const char *path, const struct dg_shaft *shaft, sd_event *event,
                                 const struct lx_clock *clock, dg_ns now, dg_ns interval,
                                 struct lx_error *error);

/** End it at the rig's `now`; NULL is fine. @return 0, or -1 with one line in `error` */
int lx_record_close(struct lx_record *self, dg_ns now, struct lx_error *error);

#endif
