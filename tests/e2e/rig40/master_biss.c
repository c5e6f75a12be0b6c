/* SPDX-License-Identifier: MIT */
/* A BiSS master's place: it asks the control plane for frames of a simulated wire. */
#define _GNU_SOURCE
#include "masters.h"

#include <stdio.h>

#define BISS_PERIOD (20 * NS_PER_MS)

static void ask_biss(struct master *self, struct device *device)
{
    char line[LINE_SIZE];
    char errors[LINE_SIZE];
    unsigned long long position = 0;
    unsigned n_err = 0;
    unsigned n_warn = 0;
    unsigned life = 0;
    unsigned crc_right = 0;
    const int64_t from = now_ns();
    tell(self, "BISS:FRAM?\n");
    tell(self, "SYST:ERR?\n");
    hear(self, line);
    if (sscanf(line, "%llu,%u,%u,%u,%u", &position, &n_err, &n_warn, &life, &crc_right) != 5) {
        become(device, "silent");
        return;
    }
    took(self, from);
    hear(self, errors);
    if (crc_right == 0) {
        become(device, "garbled");
    } else if (n_err == 0 || n_warn == 0) {
        become(device, n_err == 0 ? "nERR" : "nWARN");
    } else if (check(self, device, position, from)) {
        become(device, "ok");
    }
}

void run_biss(struct master *self)
{
    char line[LINE_SIZE];
    (void)snprintf(line, sizeof line, "INST:SEL %s\n", self->device->name);
    tell(self, line);
    while (ended == 0) {
        ask_biss(self, self->device);
        sleep_until(now_ns() + BISS_PERIOD);
    }
}
