/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The engine of the library (drehgeber/rig_engine.h) with the doors of this port: all that a plan
 * says is understood and made, nothing outside the process is touched. Then lx_bus_open() opens
 * each wire.
 */
#ifndef DREHGEBER_LINUX_ENGINE_H
#define DREHGEBER_LINUX_ENGINE_H

#include "bus.h"
#include "drehgeber/rig_engine.h"

/** What it is made of. All that it points to must outlive it. */
struct lx_engine_setup {
    struct lx_bus_setup bus; /**< what all wires share: event, say, plan, clock, writer, silkit */
    dg_ns begin;             /**< time 0 of all motions */
    const struct dg_rig_ops *ops; /**< as in dg_engine_setup */
    const struct lx_wire *door;   /**< of all wires; NULL: each is what its kind is */
    /** Wire `index` is about to be made: more that is to be right. @return 0, or -1 with `error`.
     * NULL: nothing */
    int (*wire)(void *ctx, size_t index, struct lx_error *error);
    /** dg_engine_setup.motion, .course; what they refuse is told here. */
    int (*motion)(void *ctx, size_t index, const char *path, struct dg_motion *to,
                  struct lx_error *error);
    struct dg_rig_course *(*course)(void *ctx, size_t index, const struct dg_plan_setting *setting,
                                    struct lx_error *error);
    void *ctx;
};

/** A wire. */
struct lx_engine_wire {
    struct lx_bus *bus; /**< NULL until it is made */
    struct lx_station **stations;
};

/** Encoders and wires of a plan. Not to be moved. */
struct lx_engine {
    struct lx_engine_setup setup;
    struct dg_engine *core; /**< owned, as are the arrays */
    struct dg_rig *control;
    struct lx_station *stations;  /**< in the order of the plan */
    struct lx_station **on_wires; /**< those of each wire, one wire behind the other */
    struct lx_engine_wire *wires;
    const struct dg_plan_wire *making; /**< NULL: none so far */
    struct lx_error *error;            /**< where this port says what it refuses */
    bool told;                         /**< it did */
};

/** There was no memory for it, which is not the plan's fault. */
#define LX_ENGINE_SCARCE (-2)

/** Make it. @return 0, or -1 or LX_ENGINE_SCARCE with `error`, which says where in the plan; then
 * close */
int lx_engine_make(struct lx_engine *self, const struct lx_engine_setup *setup,
                   struct lx_error *error);

/** That of a control plane. */
struct lx_engine *lx_engine_of(const struct dg_rig *control);

/** The station of an encoder. */
struct lx_station *lx_engine_station(const struct dg_rig *control,
                                     const struct dg_encoder *encoder);

/** Switch everything off, close all wires, give all back; also when all is zero. */
void lx_engine_close(struct lx_engine *self);

#endif
