/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a port knows of each protocol: one row says all that plans, messages, help and buses need.
 */
#ifndef DREHGEBER_LINUX_STACKS_H
#define DREHGEBER_LINUX_STACKS_H

#include "drehgeber/devices.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/protocols.h"
#include "drehgeber/world.h"
#include "key.h"
#include "plan.h"

struct lx_clocked_protocol;
struct lx_trace_kind;

/** A protocol of a port. */
struct lx_stack {
    const struct dg_stack *core;
    const struct dg_host_wire *handle; /**< settings of its encoders begin with the handle's */
    const struct lx_trace_kind *trace; /**< of its wires, and what messages call them */
    const struct lx_clocked_protocol *clocked; /**< on a clocked line; NULL: it is on none */
    const char *wire;                          /**< the kind of wire when none is given */
    uint32_t baud;       /**< characters: the fastest data rate that its encoders have */
    const char *spoiled; /**< what an encoder does whose EEPROM file fails, in words; NULL: it has
                            none */
    bool is_ring;        /**< encoders without a file are one thing with one address */
    struct dg_keys own;  /**< the port's rows; characters: of lx_line_encoder.sincos, */
    const void *usual;   /**< ... which is this as nobody has set it; NULL: there are none */
    const struct dg_key *instead; /**< the port's row in place of one of the handle's; NULL */
    /** Bit n: `device` has not row n of the handle's keys. NULL: each has all. */
    uint32_t (*without)(const struct dg_device *device);
    /** All are set: do they fit each other? @return 0, or -1 with `error`. NULL: they always do */
    int (*check)(const void *settings, struct lx_error *error);
};

/** That of each protocol, in the file with its settings. */
#define LX_STACK(name) extern const struct lx_stack lx_##name##_stack;
DG_PROTOCOLS(LX_STACK)
#undef LX_STACK

/** All of them. */
extern const struct lx_stack *const lx_stacks[];
extern const size_t lx_stack_count;

/** That of a device. */
const struct lx_stack *lx_stack_of(const struct dg_device *device);

/** Lists of what --set sets. */
enum lx_stack_list {
    LX_STACK_END,  /**< of an end of its wire */
    LX_STACK_OWN,  /**< the port's */
    LX_STACK_CORE, /**< the encoder's, without what has an option of its own */
    LX_STACK_WORLD,
    LX_STACK_LISTS
};

/** What can be set of an encoder and of its world, for help: `settings` and `world` have what is
 * told as the default, NULL: nothing is. `device` NULL: of all encoders of the stack. */
void lx_stack_keys(const struct lx_stack *self, const struct dg_device *device,
                   const void *settings, const struct dg_world *world,
                   struct lx_keys lists[LX_STACK_LISTS]);

/** `settings`, handle->settings_size bytes, become those of `device` as delivered. */
void lx_stack_deliver(const struct lx_stack *self, const struct dg_device *device, void *settings);

/** Append all models of the stack (NULL: all there are), with a blank in front of each. */
void lx_stack_models(const struct lx_stack *self, struct lx_words *to);

#endif
