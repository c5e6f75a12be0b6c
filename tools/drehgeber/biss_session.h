/* SPDX-License-Identifier: MIT */
/* A BiSS encoder of the command line: its figures, world, shaft, EEPROM and wire. */
#ifndef DREHGEBER_TOOL_BISS_SESSION_H
#define DREHGEBER_TOOL_BISS_SESSION_H

#include "biss_clocked.h"
#include "biss_settings.h"
#include "motion_words.h"
#include "options.h"
#include "sim_master.h"
#include "trace.h"

/* Not to be moved while open. */
struct biss_session {
    struct lx_plan plan;
    struct dg_biss_model model;
    struct dg_world world;
    struct lx_clocked_timing timing; /* of the master and its cable */
    struct lx_shaft shaft;
    struct lx_biss_memory memory;
    struct dg_biss device;
    struct lx_biss_line line;
    struct lx_tap tap;
    struct lx_sim_master master;
    struct lx_trace *trace; /* NULL: none */
};

/* The user's words become an encoder that gets its power at `now`. Its initialisation is over
   afterwards, the motion begins with the end of it. @return 0, or how the program ends, with
   `error`; to be closed in any case */
int biss_session_open(struct biss_session *self, const struct options *options, dg_ns now,
                      struct lx_error *error);

/* @return 0, or how the program ends, with `error`: the trace is not whole */
int biss_session_close(struct biss_session *self, struct lx_error *error);

#endif
