/* SPDX-License-Identifier: MIT */
/*
 * An encoder of the command line on a simulated wire that this command clocks: its figures, world,
 * shaft, EEPROM, the wire and its master. What it speaks is the line's business. Time is virtual.
 */
#ifndef DREHGEBER_TOOL_WIRE_SESSION_H
#define DREHGEBER_TOOL_WIRE_SESSION_H

#include "engine.h"
#include "motion_words.h"
#include "options.h"
#include "sim_bus.h"
#include "trace.h"

/* The words that are left of what is to be done. */
struct words {
    char *const *at;
    size_t count;
};

/* The next one, or NULL. */
const char *take_word(struct words *words);

/* Not to be moved while open. */
struct wire_session {
    struct dg_plan plan;
    struct lx_engine engine;
    struct lx_shaft shaft;
    struct lx_clocked *line;
    struct lx_tap tap;
    struct dg_bus_master master;
    struct lx_trace *trace; /* NULL: none */
};

/* A command that asks encoders of one protocol. */
struct wire_command {
    const char *name;
    const struct lx_stack *stack;
    const char *needs; /* "a BiSS model" */
    const char *right; /* what it can do */
    /* Do what the next words say. @return 0, or how the program ends, with `error` */
    int (*act)(struct wire_session *self, struct words *words, struct lx_error *error);
};

/* Do what options->words say. Prints its own errors, returns how the program ends. */
int wire_command_run(const struct wire_command *self, const struct options *options);

/* These words are not right: `what`, then `word`. @return how the program ends, with `error` */
int wire_command_usage(const struct wire_command *self, const char *what, const char *word,
                       struct lx_error *error);

/* Read a frame and print what it says. @return what the master made of it */
enum dg_master_verdict wire_session_read(struct wire_session *self);

#endif
