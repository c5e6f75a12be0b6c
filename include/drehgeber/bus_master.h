/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The master of a clocked line (bus_edges.h), for hosts that have no other: it clocks frames of all
 * encoders in virtual time, takes its samples as late as the cable is long, and says what it reads.
 *
 *   struct dg_bus_master_setup setup = {sizeof setup, bus, &dg_biss_master, .clock_hz = 1000000};
 *   dg_bus_master_init(&master, &setup, now)
 *   dg_bus_master_pause(&master, now)     nothing happens until then
 *   dg_bus_master_read(&master)           a frame; master.now goes on by as long as it takes
 *
 * The time is the master's and runs on by as much as it clocks. What a protocol's frame is, its
 * struct dg_master_protocol knows: an object and a file each, src/PROTOCOL/master.c, linked by who
 * names it. Who looks at the bus (dg_bus_watch()) is told each frame in words, as a DG_TAP_NOTE
 * whose text lasts no longer than the call.
 */
#ifndef DREHGEBER_BUS_MASTER_H
#define DREHGEBER_BUS_MASTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus_edges.h"
#include "drehgeber/tap.h"
#include "drehgeber/text.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Room for what is said of a frame or of 64 registers, with a zero. */
#define DG_BUS_NOTE_MAX 240u
/** Numbers that a protocol keeps of the latest frame. */
#define DG_MASTER_OWN 4u

struct dg_bus_master;

/** What the master made of what an encoder sent. */
enum dg_master_verdict {
    DG_MASTER_GOOD,
    DG_MASTER_WRONG,  /**< the frame does not fit its check sum */
    DG_MASTER_SILENT, /**< there was none */
};

/** A frame, as an encoder has sent it. */
struct dg_master_word {
    uint64_t bits;     /**< right-aligned */
    uint8_t count;     /**< of them */
    uint64_t position; /**< what they say: multiturn and singleturn; likewise the next ones */
    uint32_t multiturn;
    uint32_t singleturn;
    bool error;
    bool warning;
    uint8_t life;
};

/** How the master of a protocol reads. No operation is NULL; those behind `skip` are about the
 * frame read last. */
struct dg_master_protocol {
    /** Rising edges of the clock in a frame of the encoders on `bus`, at least. */
    uint32_t (*rises)(const struct dg_bus *bus);
    /** Clock a frame of all encoders, and wait for its end. What was read goes into `self`; one
     * without an answer is counted in self->silent. */
    void (*read)(struct dg_bus_master *self);
    /** `n` frames like the one read last have gone by, and nobody has looked: as if they had been
     * read. No fault of the line is active. */
    void (*skip)(const struct dg_bus_master *self, uint64_t n);
    enum dg_master_verdict (*judge)(const struct dg_bus_master *self, size_t place);
    /** Not after DG_MASTER_SILENT, likewise the next two. */
    void (*word)(const struct dg_bus_master *self, size_t place, struct dg_master_word *to);
    /** In words, for traces. */
    void (*note)(const struct dg_bus_master *self, size_t place, struct dg_text *to);
    /** In words, for people. */
    void (*line)(const struct dg_bus_master *self, size_t place, struct dg_text *to);
};

/** What a master is made of. Everything pointed to must outlive it. */
struct dg_bus_master_setup {
    size_t size;        /**< sizeof(struct dg_bus_master_setup) */
    struct dg_bus *bus; /**< with the encoders, one protocol's */
    const struct dg_master_protocol *protocol;
    uint32_t clock_hz;      /**< 1 to 500 000 000 */
    uint32_t line_delay_ns; /**< of the cable, one way */
    bool compensates;       /**< it makes up for the cable: it measures it, or it was told */
};

/** A master. Plain data; who reads frames looks at `now`, `silent` and what was read. */
struct dg_bus_master {
    struct dg_bus_master_setup setup;
    uint32_t half_ns; /**< half a period, and */
    uint32_t rest;    /**< what it is longer, in 1 ns / (2 clock_hz) */
    uint32_t owed;    /**< of such rests so far */
    uint32_t silent;  /**< frames without an answer; counted up */
    dg_ns now;        /**< at the master's end */
    dg_ns delay;      /**< it takes its samples later by that: what the cable needs there and back,
                           as far as the master knows */
    /* of the frame read last */
    dg_ns latched; /**< the edge at which encoders latch */
    bool answered;
    bool cds;                        /**< BiSS: control data of the encoders */
    dg_ns start;                     /**< BiSS: from the first edge to the start bit */
    uint64_t bits[DG_BUS_CHAIN_MAX]; /**< of each encoder, right-aligned */
    uint32_t own[DG_MASTER_OWN];     /**< the protocol's */
};

/** The cable between such a master and its encoders, for the bus. setup->bus need not be there. */
DG_API struct dg_bus_edges_setup dg_bus_master_wire(const struct dg_bus_master_setup *setup);

/** Make one at `now`, its clock high. The encoders have their power. */
DG_API void dg_bus_master_init(struct dg_bus_master *self, const struct dg_bus_master_setup *setup,
                               dg_ns now);

/** Nothing happens until `now`; if that is over, nothing happens. Power, worlds and faults that
 * have changed are looked at. */
DG_API void dg_bus_master_pause(struct dg_bus_master *self, dg_ns now);

/** Read a frame of all encoders, and tell who looks. */
DG_API void dg_bus_master_read(struct dg_bus_master *self);

/* --- for protocols --- */

/** Half a period on, the clock is put to `level`. */
DG_API void dg_bus_master_edge(struct dg_bus_master *self, bool level);

/** A falling and a rising edge. @return the bit of this clock: as the master samples it, half a
 * period and the delay of the cable behind the rising edge */
DG_API bool dg_bus_master_bit(struct dg_bus_master *self);

/** What belongs to `at` at the master's end, which takes it later by the delay of the cable. */
DG_API bool dg_bus_master_sample(const struct dg_bus_master *self, dg_ns at);

/** The cable, there and back. */
DG_API dg_ns dg_bus_master_way(const struct dg_bus_master *self);

/** Begin a text on an encoder in `size` bytes: with its name, where there are several. */
DG_API struct dg_text dg_bus_master_text(const struct dg_bus_master *self, size_t place, char *to,
                                         size_t size);

/** Tell who looks something in words that has just happened. */
DG_API void dg_bus_master_note(const struct dg_bus_master *self, const char *text,
                               enum dg_severity severity);

/** Append "position MULTITURN:SINGLETURN". */
DG_API void dg_master_note_position(struct dg_text *to, uint32_t multiturn, uint32_t singleturn);

/** Append "MT MULTITURN  ST SINGLETURN  ANGLE deg", of a singleturn of `bits`, at most 62. */
DG_API void dg_master_line_position(struct dg_text *to, uint32_t multiturn, uint32_t singleturn,
                                    uint8_t bits);

/** Append `name`, blanks and all, and a number. */
DG_API void dg_master_say(struct dg_text *to, const char *name, uint64_t value);

#ifdef __cplusplus
}
#endif

#endif
