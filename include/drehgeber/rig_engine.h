/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A rig at work: what a plan (rig.h) says, made in memory of the host and moved on by `now`. Shafts
 * and gears, encoders with their settings, a bus for each wire, and the control plane over all of
 * them are in here; a host opens doors, keeps EEPROMs and knows what time it is.
 *
 *   struct dg_engine_setup setup = {sizeof setup, &plan, .instruments = dg_instruments, ...};
 *   size_t n = dg_engine_size(&setup);
 *   struct dg_engine *engine = dg_engine_make(memory, n, &setup, &error);
 *   dg_host_memory_load(dg_engine_encoder(engine, 0), image, bytes)      if there is one
 *   dg_engine_power(engine, now, &error)
 *   dg_bus_rx(dg_engine_bus(engine, 0), &event)                         what a master does
 *   next = dg_engine_step(engine, now)                                  time goes on
 *   dg_engine_save(engine, state, dg_engine_state_size(engine))         another one goes on from it
 *
 * An engine has a struct dg_rig (control.h): that is what clients of the control plane see of any
 * rig, whoever runs it, so the rig that runs by itself has another name.
 *
 * Nothing is allocated and nothing happens outside of these calls; memory is at a multiple of
 * DG_HOST_ALIGN, must not be moved, and is all that there is to give back. How much that is stands
 * when the plan does.
 */
#ifndef DREHGEBER_RIG_ENGINE_H
#define DREHGEBER_RIG_ENGINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus.h"
#include "drehgeber/bus_characters.h"
#include "drehgeber/bus_edges.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/control.h"
#include "drehgeber/host.h"
#include "drehgeber/key.h"
#include "drehgeber/rig.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A rig at work. Lives in the host's memory. */
struct dg_engine;

/** Settings of a wire, of every kind; those that its kind does not have are as usual. Masters that
 * are the host's look up theirs here. */
struct dg_engine_line {
    bool pace; /**< frames: each takes its time at the bit rate */
    struct dg_plan_timing timing;
    struct dg_plan_ring ring;
    struct dg_plan_simulation simulation;
};

/** Settings of an encoder's end of a line of characters. */
struct dg_engine_end {
    bool pace;     /**< requests and replies take the time they take on a line */
    bool any_line; /**< whatever the line is set to is right */
};

/** Rows of an encoder's end, for help and messages; what they set is a struct dg_engine_end. Media
 * of which nothing can be set have none. */
DG_API extern const struct dg_keys dg_engine_end_keys[DG_MEDIUM_COUNT];
/** As nobody has set it. */
DG_API extern const struct dg_engine_end dg_engine_end_usual;

/** A wire before its bus is made. It is filled by the plan, and the host may change it. */
struct dg_engine_wire {
    const struct dg_plan_wire *plan;
    struct dg_engine_line line;
    const struct dg_bus_ops *ops; /**< the door; to begin with nobody listens */
    void *ctx;
    /** The medium's own setup; only that of the medium at hand counts. Room for frames, IN image
     * and `size` are the engine's. */
    struct dg_characters_setup characters; /**< paced, unless an encoder has pace = 0 */
    struct dg_bus_frames_setup frames;     /**< in virtual time, without arbitration */
    struct dg_bus_edges_setup edges;
    struct dg_bus_words_setup words; /**< the master identifies by itself */
};

/** What a rig is made of. All that it points to must outlive the rig. */
struct dg_engine_setup {
    size_t size; /**< sizeof(struct dg_engine_setup) */
    const struct dg_plan *plan;
    dg_ns begin;         /**< motions begin then, and TIME? counts from there */
    bool memory_is_host; /**< the host has all EEPROMs (dg_host_memory_port()): there is no room for
                              them here, and which encoders have none is the host's to say */
    uint16_t frames_wait; /**< room for frames that wait, on each bus of frames; 0: as much as a
                               fast wire and its faults need, 140 kB of which nothing is touched
                               before it is used */
    /** Whose commands and faults the control plane has: dg_instruments, or some of them; encoders
     * of other protocols have no faults but of their EEPROM, and STATe? says '-' of them. NULL:
     * that is all of them, with the commands that all rigs have. */
    const struct dg_instrument *const *instruments;
    size_t instrument_count;
    const struct dg_rig_ops *ops; /**< of the control plane; NULL: dg_engine_ops */
    /** Wire `index` of the plan is about to be made: its own settings are understood, those of its
     * encoders are not yet. @return 0, or anything else with `error`. NULL: each is made as it
     * stands */
    int (*wire)(void *ctx, size_t index, struct dg_engine_wire *to, struct dg_plan_error *error);
    /** Rows of the host's own for encoder `index`, whose settings are `settings`; one that has the
     * name of a row of the encoder takes its place. @return what they are about. NULL: none */
    void *(*rows)(void *ctx, size_t index, void *settings, struct dg_keys *rows);
    /** Whether settings that are right one by one go together, and with the wire. @return 0, or
     * anything else with `error`. NULL: the encoder says it, in few words. */
    int (*check)(void *ctx, size_t index, const void *settings, struct dg_plan_error *error);
    /** The motion of the file `path`, which the plan names for shaft `index`. Its points stay while
     * the rig does. @return as `check`. NULL: files are refused, likewise below */
    int (*motion)(void *ctx, size_t index, const char *path, struct dg_motion *to,
                  struct dg_plan_error *error);
    /** The points of the file that `setting` (DG_COURSE_FORM) names: a quantity of encoder `index`
     * follows them. They and the course, whose other members are the engine's, stay while it does.
     * @return NULL with `error` */
    struct dg_rig_course *(*course)(void *ctx, size_t index, const struct dg_plan_setting *setting,
                                    struct dg_plan_error *error);
    /** The address of encoder `index`, as in "can:vcan0/5", in `size` bytes. NULL: as the plan has
     * it. */
    void (*address)(void *ctx, size_t index, char *to, size_t size);
    /** STATe?: counters of the port, as dg_rig_ops.counters. NULL: it has none. */
    void (*counters)(void *ctx, size_t index, struct dg_scpi *to);
    /** Something was done to the rig: dg_engine_next() may be earlier. NULL: the host asks anyway.
     */
    void (*woken)(void *ctx);
    void *ctx;
};

/** Bytes of the rig; 0: not a setup of this version, or a wire has no encoders, or more than its
 * medium carries. */
DG_API size_t dg_engine_size(const struct dg_engine_setup *setup);

/**
 * Make the rig: shafts turn from setup->begin on, encoders have their settings and no power.
 * Nothing outside is touched.
 * @return NULL with `error`: a setting that is not right, a gear that cannot be, memory that is too
 * small or not aligned
 */
DG_API struct dg_engine *dg_engine_make(void *memory, size_t size,
                                        const struct dg_engine_setup *setup,
                                        struct dg_plan_error *error);

/** Switch all encoders on at `now`, not before setup->begin. EEPROMs have their images by now;
 * those that have none are formatted.
 * @return 0, or DG_ERR_ARGUMENT with `error`: an encoder does not start */
DG_API int dg_engine_power(struct dg_engine *self, dg_ns now, struct dg_plan_error *error);

/** Switch encoder `index` alone on, for a host whose doors open one by one. Its bus hears of it by
 * dg_bus_changed() behind it. @return as above */
DG_API int dg_engine_power_encoder(struct dg_engine *self, size_t index, dg_ns now,
                                   struct dg_plan_error *error);

/**
 * Let time pass up to `now`: on every wire, for faults that end, each at its own moment. What wires
 * carry is told wire by wire; a host that wants all of it in the order of time goes on to
 * dg_engine_next(), again and again. A host that steps a wire itself, at its own time, may.
 * @return when to call again; DG_NEVER
 */
DG_API dg_ns dg_engine_step(struct dg_engine *self, dg_ns now);

/** The same moment; nothing happens. */
DG_API dg_ns dg_engine_next(const struct dg_engine *self);

/** Bytes of a state of the rig as it is now: what waits on its wires is in it, so that another
 * moment may need more. */
DG_API size_t dg_engine_state_size(const struct dg_engine *self);

/**
 * Save the rig: what goes on from it is the same, byte for byte and nanosecond for nanosecond:
 *
 *   in it       the moment; shafts; encoders with settings, EEPROMs (dg_host_save()) and the faults
 *               at work; how far courses are; what is between the encoders (dg_bus_save())
 *   not in it   plan and setup, with the points of motions and courses; EEPROMs of the host
 *               (dg_host_memory_port()); clients of the control plane; masters of the host
 *
 * There is no pointer in it. What is due before the present has to be done (dg_engine_step()).
 * @return enum dg_host_result: 0; DG_HOST_ERR_SPACE: `n` is less than its size; DG_HOST_ERR_STATE:
 * a bus is behind its encoders, or a motion or a course is played that only the host knows
 */
DG_API int dg_engine_save(struct dg_engine *self, void *to, size_t n);

/**
 * Go on from a state that a rig of the same plan and the same build of the library has saved, maybe
 * in another process. It is made by dg_engine_make(); it need not have had power. What a state says
 * is believed, whoever made it, but nothing that would lead out of memory or never end.
 * @return enum dg_host_result: 0; nothing was changed: DG_HOST_ERR_SPACE: too short,
 * DG_HOST_ERR_OTHER: of other parts or another build. DG_HOST_ERR_DAMAGED: its sum is wrong, or,
 * as other results of parts, they do not go together: some of them have changed then, and nothing
 * but another state makes it a rig again
 */
DG_API int dg_engine_restore(struct dg_engine *self, const void *from, size_t n);

/** The bus of wire `index` of the plan. */
DG_API struct dg_bus *dg_engine_bus(const struct dg_engine *self, size_t index);
/** What it is made of, as the host has left it; a ring's IN image is in words.in. */
DG_API const struct dg_engine_wire *dg_engine_wire_of(const struct dg_engine *self, size_t index);
/** Encoder `index` of the plan. */
DG_API struct dg_host *dg_engine_encoder(const struct dg_engine *self, size_t index);
/** Its place on its bus. */
DG_API size_t dg_engine_place(const struct dg_engine *self, size_t index);

/** Its end of the line. */
DG_API struct dg_engine_end dg_engine_end_of(const struct dg_engine *self, size_t index);

/** What clients of the control plane work on, for dg_control_init(). Encoders and shafts have the
 * order of the plan; encoder->port is the host's to set. */
DG_API struct dg_rig *dg_engine_control(struct dg_engine *self);
/** What was handed over as dg_engine_setup.ctx, for operations of the host's own. */
DG_API void *dg_engine_ctx(const struct dg_rig *rig);
/** Index in the plan of one of its encoders. */
DG_API size_t dg_engine_index(const struct dg_rig *rig, const struct dg_encoder *encoder);
/** Index in the plan of one of its shafts. */
DG_API size_t dg_engine_shaft_index(const struct dg_rig *rig, const struct dg_rig_shaft *shaft);

/** Understand the settings of a wire itself; what is not set is as it is in `line`.
 * @return 0, or -1 with `error` */
DG_API int dg_engine_line_read(const struct dg_plan *plan, const struct dg_plan_wire *wire,
                               struct dg_engine_line *line, struct dg_plan_error *error);

/**
 * What the control plane of an engine does by itself: power, world, faults, motions in words,
 * counters. A host that has more copies it, replaces what it does otherwise, and hands that over:
 *
 *   struct dg_rig_ops ops = dg_engine_ops;
 *   ops.trace = trace, setup.ops = &ops
 */
DG_API extern const struct dg_rig_ops dg_engine_ops;

#ifdef __cplusplus
}
#endif

#endif
