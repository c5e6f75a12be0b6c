/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Buses of each medium that something happens to all the time, in virtual time: what operation `i`
 * of a scene is, and when, depends on nothing but `i`, so that it can be played from anywhere. All
 * that a bus tells is kept.
 */
#ifndef TESTS_SUPPORT_BUS_SCENES_H
#define TESTS_SUPPORT_BUS_SCENES_H

#include "drehgeber/bus.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "host_rig.h"

#define BUS_SCENE_ENCODERS 3u
#define BUS_SCENE_OPERATIONS 300u
#define BUS_SCENE_TOLD_MAX 20000u
#define BUS_SCENE_ROOMS 200u
#define BUS_SCENE_BUS_MAX 16384u
#define BUS_SCENE_WORDS 8u

/** What a bus has told; all zero where nothing is said. */
struct bus_told {
    dg_ns at;
    uint32_t what[4]; /**< kind and flags, place, and two words of its own */
    uint8_t bytes[8];
};

/** A bus, its encoders, and the memory that all of it is in. */
struct bus_world {
    struct host_rig_place places[BUS_SCENE_ENCODERS];
    struct dg_host *hosts[BUS_SCENE_ENCODERS];
    struct dg_encoder control[BUS_SCENE_ENCODERS]; /**< whose faults happen to them */
    alignas(DG_HOST_ALIGN) uint8_t memory[BUS_SCENE_BUS_MAX];
    struct dg_bus_frames_room rooms[BUS_SCENE_ROOMS];
    uint16_t in[BUS_SCENE_WORDS];
    struct dg_bus *bus;
    enum dg_bus_answer answer; /**< of the first encoder's memory */
    uint64_t ticket;           /**< likewise */
    dg_ns now;
};

/** What happens. */
struct bus_scene {
    const char *name;
    const char *models[BUS_SCENE_ENCODERS]; /**< NULL: not so many */
    const struct dg_bus_medium *medium;
    const void *wire; /**< for dg_bus_setup; rooms and IN are the world's */
    uint32_t least;   /**< between two operations, ns, */
    uint32_t more;    /**< ... and up to so much more */
    void (*set)(size_t place, struct dg_host *host);
    /** What can be asked about an encoder goes behind the two words that `told` begins with. */
    void (*look)(const struct bus_world *world, size_t place, struct bus_told *told);
    void (*perform)(struct bus_world *world, unsigned i);
};
extern const struct bus_scene bus_scenes[];
extern const size_t bus_scene_count;

/** What was told, to the bus that plays: one at a time. */
extern struct bus_told bus_told[BUS_SCENE_TOLD_MAX];
extern size_t bus_told_count;

/** A bus with its encoders, as delivered, in dirty memory; nothing was told. */
void bus_scene_make(const struct bus_scene *scene, struct bus_world *world);

/** All get their power at 0, and are initialised. */
void bus_scene_begin(const struct bus_scene *scene, struct bus_world *world);

/** When operation `i` happens. */
dg_ns bus_scene_moment(const struct bus_scene *scene, unsigned i);

/** Time goes on, deadline by deadline. */
void bus_scene_pass_to(struct bus_world *world, dg_ns until);

/** Play operations `from` .. `to` - 1, each at its moment. */
void bus_scene_play(const struct bus_scene *scene, struct bus_world *world, unsigned from,
                    unsigned to);

#endif
