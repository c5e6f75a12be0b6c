/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A wire with the encoders on it, whatever it is: a door to a bus of the library. Made in two
 * steps: make() understands the plan, says how the library's bus is to be, and touches nothing
 * outside the process; open() opens files and switches the power on.
 */
#ifndef DREHGEBER_LINUX_BUS_H
#define DREHGEBER_LINUX_BUS_H

#include <systemd/sd-event.h>

#include "clock.h"
#include "drehgeber/control.h"
#include "drehgeber/rig_engine.h"
#include "plan.h"
#include "say.h"
#include "station.h"
#include "tap.h"
#include "wire.h"

struct lx_bus;
struct lx_nvm_writer;
struct lx_silkit;

/** What a bus is made of. Everything pointed to must outlive it. */
struct lx_bus_setup {
    sd_event *event;
    const struct lx_say *say;
    const struct dg_plan *plan;      /**< for messages */
    const struct dg_plan_wire *wire; /**< its row of the plan, */
    size_t index;                    /**< ... which one that is */
    struct dg_engine *engine;        /**< with its encoders; the bus is there after make() */
    struct lx_station **stations;
    size_t count; /**< at least 1 */
    const struct lx_clock *clock;
    struct lx_nvm_writer *writer; /**< of EEPROM files; NULL: they are written where they stand */
    struct lx_silkit *silkit;     /**< the rig in a simulation; for wires that are on it */
    const struct lx_wire *door;   /**< its kind here, or one in place of it */
};

/** Longest address for a ready line. */
#define LX_BUS_ADDRESS_MAX 4200u

/** What a kind of bus does. Optional ones may be NULL. */
struct lx_bus_ops {
    /** Open the wire, load the EEPROMs, switch everything on at `now`. An error is about the wire,
     * unless it says something else.
     * @return 0, or -1 with `error`; closed by close() in any case */
    int (*open)(struct lx_bus *self, dg_ns now, struct lx_error *error);
    /** What a ready line says behind "KIND:". */
    void (*address)(const struct lx_bus *self, const struct lx_station *station, char *to,
                    size_t size);
    /** The encoder has its settings: do they suit this wire? The last one may speak for all.
     * @return 0, or -1 with `error`. Optional. */
    int (*check)(struct lx_bus *self, struct lx_station *station, struct lx_error *error);
    /** Before somebody reads what the encoders and the wire have come to, or changes power, worlds,
     * faults: be what they are at `now`. Optional: a bus that always is has none. */
    void (*look)(struct lx_bus *self, dg_ns now);
    /** A shaft of a station is about to turn otherwise at `now`: what was sensed of it so far is to
     * be known. Then changed() with NULL comes. Optional: most do not mind how shafts turn. */
    void (*turns)(struct lx_bus *self, dg_ns now);
    /** Power, world or faults of a station have changed (NULL: the clock, who listens, or a shaft
     * of a wire that minds): deadlines anew. */
    void (*changed)(struct lx_bus *self, struct lx_station *station, dg_ns now);
    /** STATe?: wire_late, wire_up and counters of its own. */
    void (*counters)(const struct lx_bus *self, const struct lx_station *station,
                     struct dg_scpi *to);
    /** The wire's master is in here: what it reads of an encoder now, in one line; optional.
     * @return false: no answer */
    bool (*read)(struct lx_bus *self, struct lx_station *station, char *text, size_t size);
    /** Switch everything off, close the wire, free `self`. */
    void (*close)(struct lx_bus *self);
};

/** For a kind's own file, where the operations are static functions of these names: all but the
 * optional ones. */
#define LX_BUS_OPERATIONS                                                                          \
    .open = open_bus, .address = address, .changed = changed, .counters = counters,                \
    .close = close_bus

/** The part that all buses share; first member of each kind. */
struct lx_bus {
    const struct lx_bus_ops *ops;
    struct lx_bus_setup setup;
    struct dg_bus *core; /**< the library's, with all encoders; set between make() and open() */
    struct lx_tap tap;
    uint64_t late;   /**< deadlines missed: what is late is each kind's to say */
    uint64_t stalls; /**< times the whole process was held up while the wire was there */
};

/** The makers. */
lx_bus_make lx_line_bus_make, lx_can_bus_make, lx_ring_bus_make, lx_sim_bus_make, lx_gpio_bus_make,
    lx_silkit_bus_make;

/** For makers: a kind's own structure of `size` bytes, all zero but for its first member, a struct
 * lx_bus with `ops` and `setup`; the caller's, for free(). @return NULL with `error` */
void *lx_bus_allocate(size_t size, const struct lx_bus_ops *ops, const struct lx_bus_setup *setup,
                      struct lx_error *error);

/** Open it. @return 0, or -1 with `error`, which says where in the plan; closed by ops->close() in
 * any case */
int lx_bus_open(struct lx_bus *self, dg_ns now, struct lx_error *error);

/** A deadline that is served later than this was missed: the shortest maximum response time that
 * the manual of the RS485 encoders has for a command (5.1.2). */
#define LX_BUS_LATE DG_MS(5)

/** What was due at `deadline` is served at `now`; late, it is counted. DG_NEVER: nothing was due.
 */
void lx_bus_serve(struct lx_bus *self, dg_ns deadline, dg_ns now);

#endif
