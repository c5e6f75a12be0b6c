/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for rings: encoders behind handles on a bus, and a master that runs cycles in virtual
 * time. What they are made of is the tests'.
 */
#ifndef TESTS_SUPPORT_RING_RIG_H
#define TESTS_SUPPORT_RING_RIG_H

#include <stdalign.h>
#include <stdint.h>

#include "drehgeber/bus_words.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"

/** Most encoders, and room for each. */
#define RING_RIG_ENCODERS 4u
#define RING_RIG_MEMORY 16384u
#define RING_RIG_WORDS (RING_RIG_ENCODERS * DG_RING_WORDS_MAX)

struct ring_rig_place {
    alignas(DG_HOST_ALIGN) uint8_t bytes[RING_RIG_MEMORY];
};

struct ring_rig {
    struct dg_bus_words_setup wire; /**< may be changed before ring_rig_open() */
    struct dg_bus_ops ops;          /**< likewise; ctx is the rig */
    struct ring_rig_place places[RING_RIG_ENCODERS];
    struct ring_rig_place of_bus;
    struct dg_host *encoders[RING_RIG_ENCODERS];
    struct dg_encoder controls[RING_RIG_ENCODERS]; /**< whose faults happen to it */
    size_t count;
    struct dg_bus *bus;
    uint16_t in[RING_RIG_WORDS];
    uint16_t out[RING_RIG_WORDS];
    dg_ns now;
};

/** No encoder yet. */
void ring_rig_init(struct ring_rig *self);

/** One more behind the others, as delivered, without power. @return it */
struct dg_host *ring_rig_add(struct ring_rig *self, const char *model);

/** Switch all on at self->now, and make the bus. */
void ring_rig_open(struct ring_rig *self);

/** A data cycle at self->now. @return what became of it */
enum dg_ring_result ring_rig_cycle(struct ring_rig *self);

/** An ID cycle at self->now. @return encoders reached */
uint16_t ring_rig_identify(struct ring_rig *self);

/** The device at a place, as its protocol has it. */
void *ring_rig_device(const struct ring_rig *self, size_t place);

/** The world at a place. */
struct dg_world *ring_rig_world(const struct ring_rig *self, size_t place);

/** Switch the power at a place. */
void ring_rig_power(struct ring_rig *self, size_t place, bool on);

/** A wire fault at a place, `count` times; 0: until ring_rig_mend(). */
void ring_rig_bend(struct ring_rig *self, size_t place, enum dg_wire_fault fault, uint32_t count);
void ring_rig_mend(struct ring_rig *self, size_t place, enum dg_wire_fault fault);

#endif
