/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A handle from inside. Behind it, in the same memory: settings, device, EEPROM, each at a multiple
 * of DG_HOST_ALIGN.
 */
#ifndef DREHGEBER_HOST_PRIVATE_H
#define DREHGEBER_HOST_PRIVATE_H

#include "drehgeber/devices.h"
#include "drehgeber/host.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/world.h"

/** Events in their order. */
struct host_queue {
    uint32_t first; /**< place of the oldest one */
    uint32_t count;
    struct dg_host_event event[DG_HOST_QUEUE];
};

/** Where a shaft is: angle + floor(rate * (t - at) / 1 s). */
struct host_course {
    dg_ns at;
    dg_angle angle;
    int64_t rate; /**< 2^-32 turns per second */
};

/** Faults at work. */
struct host_faults {
    /** @return how often an event arrives, which is bent */
    unsigned (*arrives)(void *ctx, struct dg_host_event *event, bool sent);
    /** Clocked lines: what gets to the other end while the encoder's line is at `raw`. Asked behind
     * each edge of the clock. */
    bool (*bent)(void *ctx, bool raw);
    /** The host sets the quantity of the world at `offset`: the fault that bends it is over. */
    void (*overridden)(void *ctx, size_t offset);
};

/** The handle. */
struct dg_host {
    struct dg_host_line line; /**< first: operations get it and find the handle */
    const struct dg_device *device;
    const struct dg_host_wire *wire;
    void *shaft; /**< what `angle_of` is about; NULL: `course` */
    dg_angle (*angle_of)(void *shaft, dg_ns at);
    void (*heard)(void *ctx, const struct dg_host_event *event); /**< NULL: into `out` */
    void *heard_ctx;
    const struct host_faults *faults; /**< NULL: none */
    void *faults_ctx;
    struct dg_nvm nvm; /**< the host's own; ops NULL: `memory` */
    uint8_t *memory;
    uint32_t memory_size;
    dg_ns deadline; /**< of the device */
    struct dg_world world;
    struct host_course course;
    struct host_course before; /**< in force before course.at: encoders look back */
    uint8_t controller;        /**< CAN: enum dg_controller, as the host said last */
    bool made;                 /**< was switched on: settings are in force */
    bool loaded;               /**< `memory` has an image */
    bool untold;               /**< events were lost, and nobody knows yet */
    uint32_t lost;
    struct host_queue in;
    struct host_queue out;
};

/** handle.c */
size_t dg_host_round(size_t n);
/** Sizes of what stands behind a handle of this model. */
struct host_parts {
    size_t settings;
    size_t device;
    size_t memory;
};
struct host_parts dg_host_parts_of(const struct dg_device *model, const struct dg_host_wire *wire);
/** What the device is made of. */
struct dg_stack_setup dg_host_setup(struct dg_host *self);

/** physics.c: the world's angle. */
dg_angle dg_host_sense_angle(void *ctx, dg_ns now);
/** Sit on a shaft; NULL: on the own one. */
void dg_host_sit(struct dg_host *self, void *shaft, dg_angle (*angle_of)(void *shaft, dg_ns at));

/** time.c: whatever is due up to `now` happens, and what the host changed is looked at. */
void dg_host_run(struct dg_host *self, dg_ns now);
/** Of wires that say no more: whether `event` is an edge. @return as dg_host_wire.check */
int dg_host_check_edge(const struct dg_host_event *event);

#endif
