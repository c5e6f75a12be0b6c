/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a rig is made of, for the files that make it: rig_open.c opens and closes, rig_ops.c serves
 * the control plane, rig_watch.c listens to the wires.
 */
#ifndef DREHGEBER_LINUX_RIG_PARTS_H
#define DREHGEBER_LINUX_RIG_PARTS_H

#include "engine.h"
#include "motion_words.h"
#include "record.h"
#include "rig.h"
#include "server.h"
#include "silkit.h"
#include "stall.h"
#include "timer.h"
#include "trace.h"

/** Decoded lines of a wire that are kept for TRACe:LAST?. */
#define LX_RIG_LINES 32u
/** Motions whose points a shaft may borrow: the one in force, the one before, and the next. */
#define LX_RIG_MOTIONS 3u

struct lx_rig_wire;
struct lx_rig_topics;
struct lx_courses;

/** A shaft. */
struct lx_rig_shaft {
    struct dg_rig_shaft *control; /**< the engine's */
    struct lx_rig_wire **minders; /**< owned: wires that mind how it turns, or what it drives */
    size_t minder_count;
    struct lx_shaft motion[LX_RIG_MOTIONS];
    char *text;             /**< of the motion that a client has played last; owned; NULL: none */
    const char *planned;    /**< motion of the plan; NULL: none */
    struct lx_csv *reading; /**< of a motion that is to be played; NULL: none */
    char *reads;            /**< its name; owned */
    struct lx_record *record;
    unsigned turns; /**< how often it was turned, modulo 2^32 */
};

/** A wire. */
struct lx_rig_wire {
    struct lx_rig *rig;
    const struct dg_plan_wire *plan;
    struct lx_bus *bus;
    struct lx_trace *trace;
    bool listens;
    struct lx_tap_listener listener;
    struct dg_words_wire words; /**< its memory is owned */
    struct lx_timer silence;    /**< the end of a frame that nothing follows */
    struct dg_rig_line *lines;  /**< owned */
    size_t line_count; /**< so far; the newest is in lines[(line_count - 1) % LX_RIG_LINES] */
};

/** What the first encoder on a wire speaks; most wires have one protocol. */
const struct lx_stack *lx_rig_stack(const struct lx_rig *self, size_t wire);

/** Whether another one speaks something else. */
bool lx_rig_mixed(const struct lx_rig_wire *self);

/** What tells the wire in words; NULL: its protocol has none, or there are several, and nobody
 * knows which of them a request is for. */
const struct dg_words *lx_rig_words(const struct lx_rig_wire *self);

/** A rig. */
struct lx_rig {
    struct lx_rig_setup setup;
    struct lx_engine engine;
    struct dg_rig_ops ops; /**< what its control plane does */
    struct dg_rig *control;
    struct lx_clock clock;
    dg_ns begin; /**< its time when it was opened */
    struct lx_rig_shaft *shafts;
    struct lx_rig_wire *wires;
    struct lx_nvm_writer *writer; /**< of EEPROM files */
    struct lx_silkit *silkit;     /**< the rig in a simulation, if it is in one: */
    struct lx_rig_topics *topics; /**< of each shaft; owned; NULL: it is in none */
    enum lx_rig_result result;    /**< what a failure of the engine comes to */
    struct lx_courses **courses;  /**< of each encoder; NULL: none; owned */
    struct lx_timer faults;       /**< their durations, and courses */
    struct lx_stall stall;
    dg_ns stalled;          /**< when the last long one ended; 0: there was none */
    struct lx_folder files; /**< of clients */
    struct lx_folder no_files;
    const struct lx_folder *folder; /**< of the client that is served; NULL: none is */
    bool stands;                    /**< nothing can be refused any more: traces are written */
    size_t recorded;                /**< shafts that are */
    struct lx_server *servers[DG_PLAN_CONTROLS_MAX];
    char address[LX_BUS_ADDRESS_MAX + 16u]; /**< of the encoder asked for last */
};

/** What the control plane asks for, but for what the engine does by itself. */
extern const struct dg_rig_ops lx_rig_ops;

/** The rig of a control plane. */
struct lx_rig *lx_rig_of(const struct dg_rig *control);

/** The address of an encoder, "KIND:ADDRESS", in self->address. */
const char *lx_rig_address(struct lx_rig *self, const struct lx_station *station);

/** A motion file that is being read for the shaft is not, any more. */
void lx_rig_read_none(struct lx_rig_shaft *self);

/** lx_engine_setup.course. */
struct dg_rig_course *lx_rig_find_course(void *ctx, size_t index,
                                         const struct dg_plan_setting *setting,
                                         struct lx_error *error);

/** Give all courses back. */
void lx_rig_close_courses(struct lx_rig *self);

/** dg_rig_ops.course and its like. */
int lx_rig_course(struct dg_rig *control, struct dg_encoder *encoder,
                  const struct dg_rig_course_wish *wish, dg_ns now, char *detail);
int lx_rig_course_more(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now, bool gone,
                       char *detail);
const char *lx_rig_course_text(struct dg_rig *control, const struct dg_encoder *encoder,
                               size_t quantity);

/** STATe?: the settings that follow courses. */
void lx_rig_count_courses(const struct dg_encoder *encoder, struct dg_scpi *to);

/** What a client is told: its room is small, so what would be right goes when it does not fit.
 * @return `code` */
int lx_rig_refuse(int code, const struct lx_error *error, char *detail);

/** Trace a wire to `path`. @return 0, or -1 with one line in `error` */
int lx_rig_trace(struct lx_rig_wire *self, const char *path, struct lx_error *error);

/** What is due in all of the rig at `now`, and what is next. */
void lx_rig_settle(void *ctx, dg_ns now);

/** All wires are open: if one is in a SIL Kit simulation, so are the shafts, and life begins there.
 * @return 0, or -1 with one line in `error` */
int lx_rig_join(struct lx_rig *self, struct lx_error *error);

/** Decode what goes over a wire from now on; again: nothing. @return 0, or -1 with `error` */
int lx_rig_listen(struct lx_rig_wire *self, struct lx_error *error);

/** Stop that; also when it was not done. */
void lx_rig_deaf(struct lx_rig_wire *self);

#endif
