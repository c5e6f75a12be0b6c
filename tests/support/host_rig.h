/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders behind handles, for tests that know nothing but host.h.
 */
#ifndef TESTS_SUPPORT_HOST_RIG_H
#define TESTS_SUPPORT_HOST_RIG_H

#include <stdalign.h>
#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/host.h"

/** One to be made of its struct. */
extern const struct dg_device dg_ssi_25;

/** Time and angle. READY: longer than any model initialises. */
#define MS UINT64_C(1000000)
#define SECOND (1000 * MS)
#define READY SECOND
#define TURN ((int64_t)1 << 32)

/** Room for any handle, its states, and any panel. */
#define HOST_RIG_MEMORY_MAX 32768u
struct host_rig_place {
    alignas(DG_HOST_ALIGN) uint8_t bytes[HOST_RIG_MEMORY_MAX];
};
extern struct host_rig_place host_rig_here;
extern struct host_rig_place host_rig_there;

/** All models there are, in the order they are listed. */
struct host_rig_model {
    const char *name;
    const char *resolution; /**< in words */
    bool senses_multiturn;
    bool has_memory;
    const char *protocol;
    const struct dg_host_wire *wire;
    enum dg_host_medium medium;
    const char *address_key;
    uint64_t position; /**< at 3.25 turns */
    uint8_t width;     /**< bits of a frame, or bytes of a cycle */
};
extern const struct host_rig_model host_rig_models[];
extern const size_t host_rig_model_count;

/** The row of a model; the test has failed if there is none. */
const struct host_rig_model *host_rig_model(const char *name);

/** A handle in a memory that was used before. */
struct dg_host *host_rig_make(struct host_rig_place *place, const char *name);

/** The same with power since 0, initialised, at rest at 3.25 turns. */
struct dg_host *host_rig_start(struct host_rig_place *place, const char *name);

/** Fetch until nothing is left. */
void host_rig_drain(struct dg_host *self);

#endif
