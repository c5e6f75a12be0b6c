/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Kinds of wire, as a plan names them; what one is made of is bus.h.
 */
#ifndef DREHGEBER_LINUX_WIRE_H
#define DREHGEBER_LINUX_WIRE_H

#include <stdbool.h>
#include <stddef.h>

#include "drehgeber/devices.h"
#include "say.h"

struct lx_bus;
struct lx_bus_setup;

/** Understand the plan: figures, settings, addresses. @return NULL with one line in `error` */
typedef struct lx_bus *lx_bus_make(const struct lx_bus_setup *setup, struct lx_error *error);

/** A kind of wire. */
struct lx_wire {
    const char *name;    /**< as in "ready MODEL WIRE:ADDRESS" and --WIRE */
    size_t stations_max; /**< encoders that fit on one */
    lx_bus_make *make;
    const char *where; /**< what its address looks like, for messages, e.g. "CHIP:MA,SLO"; NULL: it
                            has none */
    const char *usual; /**< address when none is given; NULL: the bus finds one */
    const char *const *keys; /**< settings of the wire itself, NULL behind the last; NULL: none */
    const struct dg_stack *stack;
    bool simulated; /**< runs by the rig's clock, which may be slowed down */
    bool where_needed;
    bool where_is_path; /**< a file name: in a rig file relative to its folder */
};

/** All kinds. */
extern const struct lx_wire lx_wires[];
extern const size_t lx_wire_count;

/** The kind called `name` (n characters), or NULL. */
const struct lx_wire *lx_wire_find(const char *name, size_t n);

/** Whether `key` is a setting of the wire itself, not of the encoders on it. */
bool lx_wire_has(const struct lx_wire *self, const char *key);

#endif
