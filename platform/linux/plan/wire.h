/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Kinds of wire, as a plan names them; what one is made of is bus.h.
 */
#ifndef DREHGEBER_LINUX_WIRE_H
#define DREHGEBER_LINUX_WIRE_H

#include <stdbool.h>
#include <stddef.h>

#include "stacks.h"

struct lx_bus;
struct lx_bus_setup;

/** Understand the plan: figures, settings, addresses. @return NULL with `error` */
typedef struct lx_bus *lx_bus_make(const struct lx_bus_setup *setup, struct lx_error *error);

/** In lx_wire.media: it carries what travels as DG_MEDIUM_`medium`. */
#define LX_CARRIES(medium) (1u << DG_MEDIUM_##medium)
#define LX_CARRIES_ALL ((1u << DG_MEDIUM_COUNT) - 1u)

/** A kind of wire. */
struct lx_wire {
    const char *name;    /**< as in "ready MODEL WIRE:ADDRESS" and --WIRE */
    size_t stations_max; /**< encoders that fit on one; all of one stack, unless it is mixed */
    lx_bus_make *make;
    unsigned media;    /**< it can carry: LX_CARRIES() */
    const char *where; /**< what its address looks like, for messages, e.g. "CHIP:CLOCK,DATA"; NULL:
                          it has none */
    const char *usual; /**< address when none is given; NULL: the bus finds one */
    const struct lx_keys *keys; /**< settings of the wire itself; NULL: none */
    const void *defaults;       /**< what they set, as nobody has set it */
    bool simulated;             /**< runs by the rig's clock, which may be slowed down */
    bool mixed;                 /**< stacks of several may be on one */
    bool where_needed;
    bool where_is_path;    /**< a file name: in a rig file relative to its folder */
    bool where_may_be_tcp; /**< ... or tcp:HOST:PORT */
    bool where_in_trace;   /**< its address is the name of the wire in a trace */
    const char *help;      /**< what it is, in one line */
};

/** All kinds. */
extern const struct lx_wire lx_wires[];
extern const size_t lx_wire_count;

/** The kind called `name` (n characters), or NULL. */
const struct lx_wire *lx_wire_find(const char *name, size_t n);

/** Whether the bus finds an address by itself. */
bool lx_wire_is_optional(const struct lx_wire *self);

/** Whether an address of it is a path. */
bool lx_wire_is_path(const struct lx_wire *self, const char *where);

/** Whether encoders of `stack` can be on it. */
bool lx_wire_carries(const struct lx_wire *self, const struct lx_stack *stack);

/** Whether `key` is a setting of the wire itself, not of the encoders on it. */
bool lx_wire_has(const struct lx_wire *self, const char *key);

/** Append the names of all kinds with this setting, when it is one of a wire itself: of that, or of
 * the port for what they carry. @return how many */
size_t lx_wires_with(const char *key, struct lx_words *names);

/** Understand the settings of the wire itself: those in `keys`, to `base`, which has the defaults.
 * @return 0, or -1 with `error` */
int lx_wire_settings(const struct lx_keys *keys, const struct lx_plan *plan,
                     const struct lx_plan_wire *wire, void *base, struct lx_error *error);

#endif
