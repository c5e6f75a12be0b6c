/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A clocked protocol that no encoder has: a word of ten bits, most significant bit first, from the
 * first falling edge of the clock on; no start bit, no Ack, no chain. Whoever clocks on gets the
 * word again, behind a 0. Its figures are those of no device.
 */
#ifndef DREHGEBER_TENBIT_H
#define DREHGEBER_TENBIT_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_bus_side;
struct dg_host_wire;
struct dg_instrument;
struct dg_master_protocol;

/** Bits of a word. */
#define DG_TENBIT_BITS 10u
/** All of them. */
#define DG_TENBIT_ALL ((1u << DG_TENBIT_BITS) - 1u)
/** Silence of the clock that ends a word. */
#define DG_TENBIT_MONOFLOP DG_US(20)

/** What a model is. */
struct dg_tenbit_model {
    bool open; /**< what its line reads as that nobody drives */
};

/** A device: caller-owned plain data, made by dg_tenbit_stack; readable for tests. */
struct dg_tenbit {
    const struct dg_tenbit_model *model;
    const struct dg_world *world;
    dg_ns deadline; /**< end of the word; DG_NEVER: there is none */
    uint32_t word;  /**< as latched */
    uint32_t left;  /**< bits of it to come */
    uint32_t frames;
    bool powered;
    bool clock;
    bool data;
    bool stuck; /**< for tests: it asks for the present again and again */
};

/** An edge of the clock at `now`, or none. @return the level of the data line */
DG_API bool dg_tenbit_clock(struct dg_tenbit *self, dg_ns now, bool level);

/** The protocol: devices are struct dg_tenbit, without an EEPROM. */
DG_API extern const struct dg_stack dg_tenbit_stack;
/** One whose line is low that nobody drives, and one whose is high. */
DG_API extern const struct dg_device dg_tenbit_low, dg_tenbit_high;
/** Nothing can be set of it. */
DG_API extern const struct dg_keys dg_tenbit_keys;
/** The protocol behind a handle, and as an instrument: a delay takes 3 us. */
DG_API extern const struct dg_host_wire dg_tenbit_wire;
DG_API extern const struct dg_bus_side dg_tenbit_side;
DG_API extern const struct dg_instrument dg_tenbit_instrument;
/** Its master, see bus_master.h. */
DG_API extern const struct dg_master_protocol dg_tenbit_master;
/** What looks at a device that somebody has made, see stack.h. */
DG_API extern const struct dg_stack_check dg_tenbit_state;

#ifdef __cplusplus
}
#endif

#endif
