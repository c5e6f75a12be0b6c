/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A shaft's motion into a CSV file, which motions and SHAFt:PROFile replay.
 */
#ifndef DREHGEBER_LINUX_RECORD_H
#define DREHGEBER_LINUX_RECORD_H

#include <systemd/sd-event.h>

#include "bus.h"
#include "drehgeber/shaft.h"
#include "file.h"
#include "say.h"

/** A recording. */
struct lx_record;

/** What is recorded, and where. Shaft, event loop and clock must outlive the recording. */
struct lx_record_setup {
    const char *path; /**< ends in .csv */
    const struct dg_shaft *shaft;
    sd_event *event;
    const struct lx_clock *clock;
    dg_ns interval;                 /**< 100 us .. 1 h */
    const struct lx_folder *folder; /**< of the client that asks; NULL: anywhere */
};

/**
 * Write "time_s,angle_deg" every `interval` from the rig's `now` on, time 0 being now; exact
 * moments of the grid, not of the wake-ups, and angles that read back as the same angle. A full
 * disk, an angle beyond the 6000000000 degrees that can be read back, or a clock that makes more
 * than 10000000 lines due at once, ends it with one complaint.
 * @return NULL with one line in `error`
 */
struct lx_record *lx_record_open(const struct lx_record_setup *setup, dg_ns now,
                                 struct lx_error *error);

/**
 * Write what is due at the rig's `now`. Happens by itself as time passes; who calls it after each
 * command to the shaft, and after time was stepped, gets every moment as it was, however many
 * commands come between two wake-ups. NULL is fine.
 */
void lx_record_write(struct lx_record *self, dg_ns now);

/** End it at the rig's `now`; NULL is fine. @return 0, or -1 with one line in `error`, also when it
 * had to end before */
int lx_record_close(struct lx_record *self, dg_ns now, struct lx_error *error);

#endif
