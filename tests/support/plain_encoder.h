/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder of a protocol that nobody has: a word of ten bits, most significant bit first, from
 * the first falling edge of the clock on; no start bit, no Ack, no chain. Clocked lines may know
 * nothing of what they carry.
 */
#ifndef TESTS_SUPPORT_PLAIN_ENCODER_H
#define TESTS_SUPPORT_PLAIN_ENCODER_H

#include <stdbool.h>

#include "drehgeber/host_wire.h"
#include "drehgeber/instrument.h"

#define PLAIN_BITS 10u
#define PLAIN_ALL ((1u << PLAIN_BITS) - 1u)
#define PLAIN_MONOFLOP DG_US(20)

/** Its figures. */
struct plain_model {
    bool open; /**< what its line reads as that nobody drives */
};

/** Its device: readable for tests. */
struct plain {
    const struct plain_model *model;
    const struct dg_world *world;
    dg_ns deadline;
    unsigned word; /**< as latched */
    unsigned left; /**< bits of it to come */
    unsigned frames;
    bool powered;
    bool clock;
    bool data;
    bool stuck; /**< it asks for the present again and again */
};

/** One whose line is low that nobody drives, and one whose is high. */
extern const struct dg_device plain_low;
extern const struct dg_device plain_high;
/** What it is behind a handle, and as an instrument: a delay takes 3 us. */
extern const struct dg_host_wire plain_wire;
extern const struct dg_instrument plain_instrument;

#endif
