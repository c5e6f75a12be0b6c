/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of a rig at work. engine_layout.c says what stands where, engine_make.c makes it of a plan
 * (engine_settings.c: of its settings), engine_run.c moves it on, engine_ops.c serves the control
 * plane, engine_state.c keeps it.
 *
 *   | struct dg_engine | shafts | encoders | wires | courses | their lists | handles | buses, each
 * with its room |
 */
#ifndef DREHGEBER_ENGINE_PRIVATE_H
#define DREHGEBER_ENGINE_PRIVATE_H

#include "drehgeber/rig_engine.h"
#include "rig_private.h"

/** What SHAFt:PROFile? answers at most, with its zero. */
#define ENGINE_PROFILE_MAX 64u
/** Longest address that dg_rig_ops.wire answers, with its zero. */
#define ENGINE_ADDRESS_MAX 192u
/** "There is no other one." */
#define ENGINE_NOBODY SIZE_MAX

/** A shaft. */
struct engine_shaft {
    struct dg_rig_shaft control;          /**< first: the control plane's */
    char profile[ENGINE_PROFILE_MAX];     /**< the motion that is played */
    const struct dg_motion_point *points; /**< of the file that the plan names; NULL: none */
    size_t point_count;
};

/** A course that the plan names. */
struct engine_course {
    struct dg_rig_course *it; /**< the host's */
    size_t encoder;
};

/** An encoder. */
struct engine_encoder {
    struct dg_encoder control; /**< first: the control plane's */
    struct dg_host *host;
    struct dg_engine_end end;
    size_t place; /**< on its wire */
    size_t next;  /**< the one behind it there; ENGINE_NOBODY */
};

/** A wire. */
struct engine_wire {
    struct dg_engine_wire is;
    struct dg_bus *bus;
    size_t first; /**< encoder on it */
    size_t last;
};

/** The rig. */
struct dg_engine {
    struct dg_engine_setup setup;
    struct dg_rig control;
    struct engine_shaft *shafts;
    struct engine_encoder *encoders;
    struct engine_wire *wires;
    struct engine_course *courses; /**< in the order of the plan */
    size_t course_count;           /**< of those that were made */
    uint8_t *handles;              /**< one behind the other, in the order of the encoders */
    uint8_t *buses;                /**< likewise, of the wires */
    dg_ns now;
    char address[ENGINE_ADDRESS_MAX]; /**< of the encoder asked for last */
};

/** engine_layout.c: bytes of a handle, of a bus, of what a bus needs beside itself. */
size_t dg_engine_handle_size(const struct dg_engine_setup *setup, const struct dg_device *model);
size_t dg_engine_bus_size(const struct dg_plan_wire *wire);
size_t dg_engine_room_size(const struct dg_engine_setup *setup, const struct dg_plan_wire *wire);
/** Frames that may wait on a wire with so many encoders. */
size_t dg_engine_rooms(const struct dg_engine_setup *setup, size_t encoders);
/** The medium of a wire. */
const struct dg_bus_medium *dg_engine_medium(const struct dg_plan_wire *wire);
/** Memory becomes an engine whose parts have their places; handles and buses are still to be
 * made. */
void dg_engine_lay_out(struct dg_engine *self, const struct dg_engine_setup *setup);

/** engine_settings.c: what the plan says of an encoder becomes its settings.
 * @return 0, or -1 with `error` */
int dg_engine_set_encoder(struct dg_engine *self, size_t index, struct dg_plan_error *error);

/** How many courses the plan names. */
size_t dg_engine_course_count(const struct dg_plan *plan);
/** All are made: quantities that follow a course begin to. @return as above */
int dg_engine_begin_courses(struct dg_engine *self, struct dg_plan_error *error);

/** engine_run.c: an encoder has its device, if it was switched on once. */
void dg_engine_know_device(struct engine_encoder *encoder);

/** engine_ops.c: the bus that this encoder is on. */
struct dg_bus *dg_engine_bus_of(const struct dg_engine *self, const struct engine_encoder *encoder);

#endif
