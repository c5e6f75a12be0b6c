/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders on a clocked line: a master clocks, they shift.
 *
 *            clock ---->             level = edge(now, level)
 *   master               encoders
 *            <----- data             step(now) -> deadline
 *
 * GPIO lines, the simulated wire with its master, faults on the line and traces are written against
 * this seam and know no protocol. A protocol is a struct lx_clocked_protocol in a file of its own,
 * of which its struct lx_stack knows.
 */
#ifndef DREHGEBER_LINUX_CLOCKED_H
#define DREHGEBER_LINUX_CLOCKED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus.h"
#include "drehgeber/line_fault.h"
#include "drehgeber/time.h"
#include "say.h"

/** Most encoders on one line. */
#define LX_CLOCKED_MAX 8u

struct lx_clocked;
struct lx_clocked_wire;

/** What the master made of what an encoder sent. */
enum lx_clocked_verdict {
    LX_CLOCKED_GOOD,
    LX_CLOCKED_WRONG,  /**< the frame does not fit its check sum */
    LX_CLOCKED_SILENT, /**< there was none */
};

/** A frame, as an encoder has sent it. */
struct lx_clocked_word {
    uint64_t bits;      /**< right-aligned */
    uint8_t count;      /**< of them */
    uint32_t multiturn; /**< what they say; likewise the next ones */
    uint32_t singleturn;
    bool error;
    bool warning;
    uint8_t life;
};

/** What goes on on a line. */
struct lx_clocked_ops {
    const char *clock; /**< the protocol's names of the lines, for messages, e.g. "MA" */
    const char *data;

    /** The clock is at `level` from `now` on; the same level again is no edge. A deadline up to
     * `now` comes first. Faults of the line begin with the frame that they happen to.
     * @return the level of the data line at the master's end of it */
    bool (*edge)(struct lx_clocked *self, dg_ns now, bool level);
    /** Do what is due at `now`. Early, nothing happens: 0 just asks. @return when to call again;
     * DG_NEVER when only an edge can change anything */
    dg_ns (*step)(struct lx_clocked *self, dg_ns now);
    /** The level of the data line at the master's end of it. */
    bool (*level)(const struct lx_clocked *self);
    /** What the user should know at `now`, once; NULL: nothing. `due`: when to ask again, unless an
     * edge comes before. Optional: most protocols have nothing to say. */
    const char *(*hint)(struct lx_clocked *self, dg_ns now, dg_ns *due);
    /** The level of the clock as the encoders have it. */
    bool (*clocked)(const struct lx_clocked *self);
    /** No frame is on the line, and faults may have come or gone. */
    void (*settle)(struct lx_clocked *self);
    /** Rising edges of the clock in a frame, at least. */
    uint32_t (*rises)(const struct lx_clocked *self);

    /** The master of a simulated wire reads a frame of all encoders; what it saw stays in `self`.
     * A frame without an answer is counted in `wire`. */
    void (*read)(struct lx_clocked *self, struct lx_clocked_wire *wire);
    /** `n` frames like the one read last have gone by, and nobody has looked: as if they had been
     * read. No fault of the line is active. */
    void (*skip)(struct lx_clocked *self, uint64_t n);
    /** What it made of the frame read last. */
    enum lx_clocked_verdict (*judge)(const struct lx_clocked *self, size_t encoder);
    /** The frame read last; not after LX_CLOCKED_SILENT. */
    void (*word)(const struct lx_clocked *self, size_t encoder, struct lx_clocked_word *out);
    /** The frame read last in words, for traces. */
    void (*note)(const struct lx_clocked *self, const struct lx_clocked_wire *wire, size_t encoder,
                 char *text, size_t size);
    /** The same as a line for people; not after LX_CLOCKED_SILENT. */
    void (*print)(const struct lx_clocked *self, size_t encoder, char *text, size_t size);
};

/** For a protocol's own file, where these operations are static functions of the same name. */
#define LX_CLOCKED_OPERATIONS                                                                      \
    .edge = edge, .step = step, .level = level, .clocked = clocked, .settle = settle,              \
    .rises = rises, .judge = judge, .note = note

/** A line; first member of each protocol's own. Not to be moved. */
struct lx_clocked {
    const struct lx_clocked_ops *ops;
    const struct lx_clocked_protocol *protocol; /**< NULL: the line is not from a plan */
    size_t count;                               /**< encoders; the first is nearest to the master */
    const char *name[LX_CLOCKED_MAX];           /**< of the encoders */
    dg_ns period; /**< of the clock, for faults that take whole clocks */
    dg_ns init;   /**< the longest initialisation of an encoder of the plan */
};

/** Who clocks. */
enum lx_clocked_master {
    LX_CLOCKED_HERE,  /**< this program, in virtual time */
    LX_CLOCKED_THERE, /**< somebody else, as fast as GPIO lines allow */
};

/** A protocol as buses need it. */
struct lx_clocked_protocol {
    size_t encoders_max; /**< on one line, LX_CLOCKED_MAX at most */
    size_t size;         /**< of its line, encoders and all */
    /** Make a line without encoders of zeroed memory. */
    void (*init)(struct lx_clocked *self);
    /** Understand the plan of encoder `index`, and fill its station; nothing outside this program
     * is touched. Called for each in turn. @return 0, or -1 with one line in `error` */
    int (*place)(struct lx_clocked *self, const struct lx_bus_setup *setup, size_t index,
                 enum lx_clocked_master master, struct lx_error *error);
    /** Whether its encoders take `hz` of a simulated wire for the clock of one frame. Optional:
     * they take all. @return 0, or -1 with `error` */
    int (*check_rate)(const struct lx_clocked *self, uint32_t hz, struct lx_error *error);
    /** Load its EEPROM, switch it on at `now`, and put it on the line, behind the others.
     * @return 0, or -1 with one line in `error` */
    int (*open)(struct lx_clocked *self, const struct lx_bus_setup *setup, size_t index, dg_ns now,
                struct lx_error *error);
    /** Switch them all off and close their EEPROMs, opened or not. */
    void (*close)(struct lx_clocked *self);
    /** What the commands of its own find behind `station` on a simulated wire; NULL: nothing. */
    void (*offer)(struct lx_station *station);
};

/** A line with what a bus is made of, which all has to speak one protocol.
 * @return NULL with one line in `error` */
struct lx_clocked *lx_clocked_make(const struct lx_bus_setup *setup, enum lx_clocked_master master,
                                   struct lx_error *error);

/** Whether the encoders take such a clock, as lx_clocked_protocol.check_rate(). */
int lx_clocked_check_rate(const struct lx_clocked *self, uint32_t hz, struct lx_error *error);

/** Switch on encoder `index`, as lx_clocked_protocol.open(). */
int lx_clocked_open(struct lx_clocked *self, const struct lx_bus_setup *setup, size_t index,
                    dg_ns now, struct lx_error *error);

/** Switch everything off, free `self`; NULL is fine. */
void lx_clocked_close(struct lx_clocked *self);

/** Tell the user what there is to tell at `now`, about the wire called `name`.
 * @return when to ask again, unless an edge comes before */
dg_ns lx_clocked_hint(struct lx_clocked *self, const struct lx_say *say, const char *name,
                      dg_ns now);

/** What a simulated wire has for the protocol's own commands, behind each station of `setup`. */
void lx_clocked_offer(const struct lx_clocked *self, const struct lx_bus_setup *setup);

#endif
