/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A ring in a SIL Kit simulation: each step is a cycle, and somebody else has the images.
 *
 *   NETWORK/out --> OUT words, from the next cycle on
 *   NETWORK/in  <-- what the cycle came to, and IN words
 */
#ifndef DREHGEBER_LINUX_RING_SILKIT_H
#define DREHGEBER_LINUX_RING_SILKIT_H

#include "bus.h"
#include "modbus_ring.h"
#include "silkit.h"

/** The topics of a ring. */
struct lx_ring_silkit {
    struct lx_ring *ring;
    struct lx_silkit_port out;
    struct lx_silkit_port in;
    struct lx_silkit_where where;
};

/** Make them, once the ring is there; self->ring is set.
 * @return 0, or -1 with one line in `error` */
int lx_ring_silkit_open(struct lx_ring_silkit *self, const struct lx_bus_setup *setup,
                        struct lx_error *error);

#endif
