/* SPDX-License-Identifier: MIT */
/*
 * Levels of two signals of a wire as events, for formats that have levels. Their names say what the
 * wire is:
 *
 *   REQUEST, TX and REPLY, RX                    RS485: characters are taken from the levels
 *   MA, CLOCK, CLK and SLO, SL, DATA             BiSS, SSI: clock and data
 *
 *   request  ¯¯¯|_0000001~|_0100001~|¯¯¯¯¯¯      a falling edge begins a character; each bit is
 *                ^ ^ ^ ^                         the level in the middle of it
 *
 * Changes of one moment are one event of a clocked line.
 */
#ifndef DREHGEBER_TOOL_EXPLAIN_LEVELS_H
#define DREHGEBER_TOOL_EXPLAIN_LEVELS_H

#include "explain_source.h"

/* A character in each direction ends at a moment, or the line changes at it. */
#define EXPLAIN_LEVELS_EVENTS 2u

enum explain_side {
    EXPLAIN_FIRST,  /* request, clock */
    EXPLAIN_SECOND, /* reply, data */
    EXPLAIN_SIDES
};

enum explain_wire {
    EXPLAIN_UNKNOWN,
    EXPLAIN_CHARACTERS,
    EXPLAIN_CLOCKED,
};

/* A signal. */
struct explain_signal {
    bool found;
    bool level;
    bool busy; /* characters: in the middle of one */
    dg_ns start;
    unsigned count;
    uint16_t bits;
};

struct explain_levels {
    enum explain_wire wire;
    dg_ns now;
    bool changed; /* a clocked line: not told yet */
    struct explain_signal signals[EXPLAIN_SIDES];
    size_t count; /* of events that wait */
    struct dg_tap_event events[EXPLAIN_LEVELS_EVENTS];
};

/* What is missing when a file has no wire. */
extern const char explain_levels_right[];

/* A signal of this name. @return enum explain_side, if it is one of the wire; EXPLAIN_SIDES */
enum explain_side explain_levels_find(struct explain_levels *self, const char *name, size_t n);

/* Whether both signals were found. */
bool explain_levels_whole(const struct explain_levels *self);

/* A signal is at `level` from self->now on. */
void explain_levels_change(struct explain_levels *self, enum explain_side side, bool level);

/* It is `at`, later than self->now: what has ended meanwhile waits in `events`, which is empty. */
void explain_levels_advance(struct explain_levels *self, const struct dg_host_uart *uart, dg_ns at);

/* Fetch the oldest event. @return whether there is one */
bool explain_levels_take(struct explain_levels *self, struct dg_tap_event *to);

#endif
