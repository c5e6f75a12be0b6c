/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A simulated wire whose master is asked for frames by somebody in a SIL Kit simulation.
 *
 *   NETWORK/latch --> the master reads a frame, at the moment of the message
 *   NETWORK/frame <-- what it has read; as long as nobody has latched, one at each step
 */
#ifndef DREHGEBER_LINUX_SIM_SILKIT_H
#define DREHGEBER_LINUX_SIM_SILKIT_H

#include "bus.h"
#include "silkit.h"

/** The topics of a wire. */
struct lx_sim_silkit {
    struct lx_bus *bus;
    struct lx_silkit_port latch;
    struct lx_silkit_port frame;
    bool latched; /**< somebody does */
    struct lx_silkit_where where;
};

/** Make them, once the wire is there. @return 0, or -1 with one line in `error` */
int lx_sim_silkit_open(struct lx_sim_silkit *self, struct lx_bus *bus, struct lx_error *error);

#endif
