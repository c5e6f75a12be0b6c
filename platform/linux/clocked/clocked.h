/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders of a plan on a clocked line: a master clocks, they shift. The line itself is a bus of
 * the library (drehgeber/bus_edges.h), and so is the master of a simulated wire
 * (drehgeber/bus_master.h); here are the encoders with their memories.
 *
 * GPIO lines, the simulated wire, faults on the line and traces know no protocol. A protocol is a
 * struct lx_clocked_protocol in a file of its own, of which its struct lx_stack knows.
 */
#ifndef DREHGEBER_LINUX_CLOCKED_H
#define DREHGEBER_LINUX_CLOCKED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus.h"
#include "drehgeber/bus_edges.h"
#include "drehgeber/bus_master.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/time.h"
#include "say.h"
#include "tap.h"

/** Most encoders on one line. */
#define LX_CLOCKED_MAX DG_BUS_CHAIN_MAX

/** Who clocks. */
enum lx_clocked_master {
    LX_CLOCKED_HERE,  /**< this program, in virtual time */
    LX_CLOCKED_THERE, /**< somebody else, as fast as GPIO lines allow */
};

/** A protocol: what a plan may say of its encoders. */
struct lx_clocked_protocol {
    const char *clock; /**< its names of the lines, for messages, e.g. "MA" */
    const char *data;
    const struct dg_master_protocol *master; /**< how the master of a simulated wire reads */
    /** What the commands of its own find behind a station on a simulated wire, which is handed to
     * it: dg_encoder.port. NULL: nothing */
    const void *port;

    /** Settings of an encoder as delivered become what suits a master on GPIO lines, before the
     * plan says its own. NULL: they suit every master. */
    void (*slow_down)(void *settings);
    /** Whether the settings of an encoder suit this master. @return 0, or -1 with one line in
     * `error`. NULL: they do */
    int (*check)(const struct lx_bus_setup *setup, const struct lx_station *station,
                 enum lx_clocked_master master, struct lx_error *error);
    /** How long an encoder initialises. NULL: not at all */
    dg_ns (*init)(const void *settings);
    /** Whether an encoder takes `hz` of a simulated wire for the clock of one frame. Optional:
     * it takes all. @return 0, or -1 with `error` */
    int (*check_rate)(const void *settings, uint32_t hz, struct lx_error *error);
};

/** A line. Not to be moved. */
struct lx_clocked {
    const struct lx_clocked_protocol *protocol;
    enum lx_clocked_master master;
    struct dg_bus *bus;                         /**< NULL: not connected yet */
    size_t count;                               /**< encoders; the first is nearest to the master */
    bool data;                                  /**< the level of data at the master's end */
    const struct lx_tap *tap;                   /**< who is told what goes over the line */
    struct dg_bus_ops ops;                      /**< of the bus, whose ctx is the line */
    struct lx_nvm_queue *queue[LX_CLOCKED_MAX]; /**< NULL: nobody waits for it */
    struct lx_station **station;                /**< of a plan; NULL: they are of none */
};

/** A line of `protocol` without encoders, on no bus. @return NULL: no memory */
struct lx_clocked *lx_clocked_new(const struct lx_clocked_protocol *protocol);

/** A line with what a bus is made of, which all speaks one protocol; `to` gets its door.
 * Nothing outside this program is touched. @return NULL with one line in `error` */
struct lx_clocked *lx_clocked_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                   enum lx_clocked_master master, struct lx_error *error);

/** Whether the settings of a station suit its master, as lx_clocked_protocol.check(). */
int lx_clocked_check(const struct lx_clocked *self, const struct lx_bus_setup *setup,
                     const struct lx_station *station, struct lx_error *error);

/** Whether the encoders take such a clock, as lx_clocked_protocol.check_rate(). */
int lx_clocked_check_rate(const struct lx_clocked *self, uint32_t hz, struct lx_error *error);

/** The longest initialisation of an encoder of the plan. */
dg_ns lx_clocked_init(const struct lx_clocked *self);

/** Load the EEPROMs, switch all on at `now`, and put them on `bus`, the library's. `tap` must
 * outlive the line. @return 0, or -1 with one line in `error` */
int lx_clocked_open(struct lx_clocked *self, const struct lx_bus_setup *setup, struct dg_bus *bus,
                    const struct lx_tap *tap, dg_ns now, struct lx_error *error);

/** `bus` has the encoders of the line. */
void lx_clocked_connect(struct lx_clocked *self, struct dg_bus *bus, const struct lx_tap *tap);

/** Encoder `index` does not acknowledge what is not yet through this queue. */
void lx_clocked_hold(struct lx_clocked *self, size_t index, struct lx_nvm_queue *queue);

/** Before edges come: who listens. They cost most of the time of a frame. */
void lx_clocked_listen(struct lx_clocked *self);

/** Power, worlds or faults may have changed; time goes on to `now`, or not at all. */
void lx_clocked_look(struct lx_clocked *self, dg_ns now);

/** Switch everything off, free `self`; NULL is fine. */
void lx_clocked_close(struct lx_clocked *self);

/** Tell the user what there is to tell at `now`, about the wire called `name`.
 * @return when to ask again, unless an edge comes before */
dg_ns lx_clocked_hint(struct lx_clocked *self, const struct lx_say *say, const char *name,
                      dg_ns now);

#endif
