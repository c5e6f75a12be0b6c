/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Doors: what this port makes of the kinds of wire that a plan names. What one is made of is bus.h.
 */
#ifndef DREHGEBER_LINUX_WIRE_H
#define DREHGEBER_LINUX_WIRE_H

#include <stdbool.h>
#include <stddef.h>

#include "stacks.h"

struct dg_engine_wire;
struct lx_bus;
struct lx_bus_setup;
struct lx_can;
struct lx_can_setup;
struct lx_serial;
struct lx_serial_setup;

/** Understand the address, say in `to` what the library's bus is made of. Encoders have no settings
 * yet. @return NULL with `error` */
typedef struct lx_bus *lx_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                   struct lx_error *error);

/** What this port makes of a kind of wire (dg_plan_wires). */
struct lx_wire {
    const char *name; /**< of the kind; it is in "ready MODEL WIRE:ADDRESS" and --WIRE, too */
    lx_bus_make *make;
    /** What it opens where characters, and where frames of CAN go. @return NULL with `error` */
    struct lx_serial *(*open_port)(const struct lx_serial_setup *setup, struct lx_error *error);
    struct lx_can *(*open_can)(const struct lx_can_setup *setup, struct lx_error *error);
    /** Before it is made: is this an address of it? NULL: what makes or opens it says that.
     * @return 0, or -1 with `error` */
    int (*check)(const char *where, struct lx_error *error);
    bool driven;         /**< a simulation takes the place of its master */
    bool simulated;      /**< runs by the rig's clock, which may be slowed down */
    bool where_in_trace; /**< its address is the name of the wire in a trace */
    const char *help;    /**< what it is, in one line */
};

/** All of them. */
extern const struct lx_wire lx_wires[];
extern const size_t lx_wire_count;

/** That of a kind; each has one. */
const struct lx_wire *lx_wire_of(const struct dg_plan_wire_kind *kind);

/** Whether the bus finds an address by itself. */
bool lx_wire_is_optional(const struct dg_plan_wire_kind *kind);

#endif
