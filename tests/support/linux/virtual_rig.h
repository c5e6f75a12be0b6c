/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A whole rig in virtual time, in this process, with a master at a TCP port of its first wire and a
 * client of its control plane. Time passes only where a function here says so, and not before all
 * that was said has arrived: each run is the same, to the nanosecond. One at a time; what goes
 * wrong with it ends the program.
 */
#ifndef TESTS_SUPPORT_VIRTUAL_RIG_H
#define TESTS_SUPPORT_VIRTUAL_RIG_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/control.h"
#include "plan.h"
#include "rig.h"
#include "tap.h"

/** The rig, its master and its client. Not to be moved while open. */
struct virtual_rig {
    const char *name;
    struct dg_plan plan;
    sd_event *event;
    struct lx_rig *rig;
    struct lx_tap_listener *listener;
    struct dg_control control;
    char answer[8192]; /**< to the last question, without the end of its line */
    int line;          /**< the master's connection; -1: it has none */
    /** What the master hears, in pieces; NULL: nobody listens. */
    void (*heard)(void *ctx, const uint8_t *bytes, size_t n);
    void *ctx;
};

/** A rig file, from now on; `listener`, which may be NULL, is told of its first wire. `self` is all
 * zero but for heard and ctx. */
void virtual_rig_open(struct virtual_rig *self, const char *file, struct lx_tap_listener *listener);

/** Everything off and free. */
void virtual_rig_close(struct virtual_rig *self);

/** The kind of its first wire, "rs485" for one. */
const char *virtual_rig_wire(const struct virtual_rig *self);

/** Its encoders. @return the one with this index; NULL: there is none */
const struct dg_encoder *virtual_rig_encoder(const struct virtual_rig *self, size_t index);

/** The master comes to the wire, which has a TCP port of 127.0.0.1. */
void virtual_rig_connect(struct virtual_rig *self);

/** The master says this now. */
void virtual_rig_say(struct virtual_rig *self, const uint8_t *bytes, size_t n);

/** All that happens without time: what has been said is heard. */
void virtual_rig_serve(struct virtual_rig *self);

/** Time goes on, up to a moment; for so long. */
void virtual_rig_pass_to(struct virtual_rig *self, dg_ns end);
void virtual_rig_pass(struct virtual_rig *self, dg_ns span);

/** A line of the client; what is answered is in self->answer. */
void virtual_rig_ask(struct virtual_rig *self, const char *command);

/** One that must not be refused, printf style. */
void virtual_rig_order(struct virtual_rig *self, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
