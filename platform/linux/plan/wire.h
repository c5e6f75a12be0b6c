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

/** A kind of wire. */
struct lx_wire {
    struct dg_plan_wire_kind kind; /**< what plans say of it; the name is in "ready MODEL
                                        WIRE:ADDRESS" and --WIRE, too */
    lx_bus_make *make;
    const void *defaults; /**< what kind.keys set, as nobody has set it */
    bool simulated;       /**< runs by the rig's clock, which may be slowed down */
    bool where_in_trace;  /**< its address is the name of the wire in a trace */
    const char *help;     /**< what it is, in one line */
};

/** All kinds. */
extern const struct lx_wire lx_wires[];
extern const size_t lx_wire_count;

/** The kind called `name` (n characters), or NULL. */
const struct lx_wire *lx_wire_find(const char *name, size_t n);

/** That of a wire of a plan. */
const struct lx_wire *lx_wire_of(const struct dg_plan_wire_kind *kind);

/** Whether the bus finds an address by itself. */
bool lx_wire_is_optional(const struct lx_wire *self);

/** Whether encoders of `stack` can be on it. */
bool lx_wire_carries(const struct lx_wire *self, const struct lx_stack *stack);

/** Whether `key` is a setting of the wire itself, not of the encoders on it. */
bool lx_wire_has(const struct lx_wire *self, const char *key);

/** Append the names of all kinds with this setting, when it is one of a wire itself: of that, or of
 * the port for what they carry. @return how many */
size_t lx_wires_with(const char *key, struct lx_words *names);

/** Understand the settings of the wire itself: those in `keys`, to `base`, which has the defaults.
 * @return 0, or -1 with `error` */
int lx_wire_settings(const struct dg_keys *keys, const struct dg_plan *plan,
                     const struct dg_plan_wire *wire, void *base, struct lx_error *error);

#endif
