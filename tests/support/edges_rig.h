/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A clocked line of the library with handles on it, in virtual time, and a master as simple as can
 * be. There is one rig; edges_rig_begin() makes it anew.
 */
#ifndef TESTS_SUPPORT_EDGES_RIG_H
#define TESTS_SUPPORT_EDGES_RIG_H

#include <stdalign.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/bus_edges.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "host_rig.h"

#define EDGES_RIG_ENCODERS 3u
#define EDGES_RIG_HALF 500u /**< of a period of the clock, ns */
#define EDGES_RIG_HEARD_MAX 256u

/** An encoder, and what faults happen to it. */
struct edges_rig_place {
    struct host_rig_place memory;
    struct dg_host *host;
    struct dg_encoder control;
};

/** A bus, what it told, and what it is answered. */
struct edges_rig {
    alignas(DG_HOST_ALIGN) uint8_t memory[32768];
    struct dg_bus *bus;
    struct dg_bus_ops ops;
    struct edges_rig_place place[EDGES_RIG_ENCODERS];
    struct dg_tap_event heard[EDGES_RIG_HEARD_MAX]; /**< at the master's end */
    size_t heard_count;
    unsigned taps;
    dg_ns tapped;
    enum dg_bus_answer answer; /**< given once `ops.answer` is edges_rig_answer() */
    dg_ns now;
};
extern struct edges_rig edges_rig;

/** A bus at the moment 0, with room for so many. */
void edges_rig_begin(const struct dg_bus_edges_setup *wire, size_t encoders);

/** A handle without queues, not yet on the bus. @param instrument NULL: none */
struct dg_host *edges_rig_make(struct edges_rig_place *self, const struct dg_device *model,
                               const struct dg_bus_side *side,
                               const struct dg_instrument *instrument);
/** One of the models that everybody knows, at its place. */
struct dg_host *edges_rig_model(size_t place, const char *name);

/** Put it on the bus, behind the others. */
void edges_rig_attach(size_t place);
/** Switch its power, now. */
void edges_rig_power(size_t place, bool on);

/** A fault happens to its line `count` times, 0: from now on; and none any more. */
void edges_rig_bend(size_t place, enum dg_wire_fault fault, uint32_t count);
void edges_rig_heal(size_t place);

/** dg_bus_ops.answer. */
enum dg_bus_answer edges_rig_answer(void *ctx, size_t place);

/** A falling and a rising edge. @return data behind it */
bool edges_rig_clock(void);
/** `n` of them. @return data behind each, the last in bit 0 */
uint64_t edges_rig_take(unsigned n);
/** Silence, by which any frame is over. */
void edges_rig_rest(void);

#endif
