/* SPDX-License-Identifier: MIT */
/* A BiSS master's place: it asks the control plane for frames of a simulated wire. */
#define _GNU_SOURCE
#include "masters.h"

#include <math.h>
#include <stdio.h>

#define BISS_PERIOD (20 * NS_PER_MS)
/* The rig's master may just have begun a frame of its own, behind which this one waits: 33 clocks
 * of position, 12 more bits, Ack, busy and timeout at 1 MHz. */
#define BISS_FRAME (NS_PER_MS / 10)

static void ask_biss(struct master *self, struct device *device)
{
    char line[LINE_SIZE];
    char errors[LINE_SIZE];
    const char *rest = line;
    const int64_t from = now_ns();
    tell(self, "BISS:FRAM?\n");
    tell(self, "SYST:ERR?\n");
    hear(self, line);
    const double position = number(&rest);
    const double n_err = number(&rest);
    const double n_warn = number(&rest);
    (void)number(&rest); /* the life counter */
    const double crc_right = number(&rest);
    if (isnan(crc_right)) { /* the frame's error instead */
        become(device, "silent");
        return;
    }
    took(self, from);
    hear(self, errors);
    if (crc_right != 1) {
        become(device, "garbled");
    } else if (n_err != 1 || n_warn != 1) {
        become(device, n_err != 1 ? "nERR" : "nWARN");
    } else if (check(self, device, (uint64_t)position, from)) {
        become(device, "ok");
    }
}

void run_biss(struct master *self)
{
    char line[LINE_SIZE];
    (void)snprintf(line, sizeof line, "INST:SEL %s\n", self->device->name);
    tell(self, line);
    self->ahead = BISS_FRAME;
    while (goes_on(self)) {
        ask_biss(self, self->device);
        sleep_until(now_ns() + BISS_PERIOD);
    }
}
