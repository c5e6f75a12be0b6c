/* SPDX-License-Identifier: MIT */
/**
 * @file
 * BiSS encoders on a simulated wire: a master that clocks every edge, in virtual time. The wire's
 * time is the master's and runs on by as much as a frame takes. A cable delays MA and SLO; the
 * master measures by how much with every Ack and takes its samples later by that.
 */
#ifndef DREHGEBER_LINUX_BISS_WIRE_H
#define DREHGEBER_LINUX_BISS_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "cable.h"
#include "line_fault.h"

/** The master's clock: as usual, and the slowest and fastest one that the encoder is made for.
 * Below 38.5 kHz half a period would be longer than its timeout, which ended every frame. */
#define LX_BISS_CLOCK_HZ 1000000u
#define LX_BISS_CLOCK_MIN_HZ 50000u
#define LX_BISS_CLOCK_MAX_HZ 10000000u

/** Times of the master and its cable. */
struct lx_biss_timing {
    uint32_t clock_hz;      /**< LX_BISS_CLOCK_MIN_HZ..LX_BISS_CLOCK_MAX_HZ */
    uint32_t line_delay_ns; /**< each way; 0..LX_CABLE_DELAY_MAX_NS */
};

/** What an access can end in; what is not negative counts registers. */
enum lx_biss_failure {
    LX_BISS_SILENT = -1,   /**< the encoder did not answer */
    LX_BISS_REFUSED = -2,  /**< register not implemented, protected, or not ready */
    LX_BISS_TOO_BUSY = -3, /**< longer than 20 ms */
    LX_BISS_DAMAGED = -4,  /**< a check sum is wrong */
};

/** What belongs to an encoder on the wire. */
struct lx_biss_slave {
    struct dg_faults *faults; /**< NULL: none */
    uint8_t data_bits;        /**< behind CDS */
    uint64_t bits;            /**< of the last frame, right-aligned */
    struct lx_line_fault link;
};

/** The wire. Not to be moved. */
struct lx_biss_wire {
    struct dg_biss_chain chain;
    struct lx_biss_slave slave[DG_BISS_CHAIN_MAX];
    struct lx_cable cable;
    uint32_t edges_per_s; /**< of MA */
    uint32_t half_ns;     /**< half a period, and */
    uint32_t rest;        /**< what it is longer, in 1 ns / edges_per_s */
    uint32_t owed;        /**< of such rests so far */
    dg_ns now;            /**< at the master's end */
    bool ma;              /**< at the master's end */
    bool slo;             /**< at the master's end */
    bool cds;             /**< of the last frame */
    bool answered;        /**< there was an Ack in the last frame */
    dg_ns delay;     /**< of the last frame's Ack: there and back; what the master reckons with */
    dg_ns start;     /**< from e1 to the start bit of the last frame, without that delay */
    uint32_t silent; /**< frames without Ack; counted up */
    /** The levels at the master's end from `at` on, whenever one has changed; NULL: nobody wants
     * to know. */
    void (*levels)(void *ctx, dg_ns at, bool ma, bool slo);
    void *ctx;
};

/** A wire without encoders at `now`. */
void lx_biss_wire_init(struct lx_biss_wire *self, const struct lx_biss_timing *timing, dg_ns now);

/** Put `device`, which has its model and its power, behind the others; at most DG_BISS_CHAIN_MAX.
 */
void lx_biss_wire_add(struct lx_biss_wire *self, struct dg_biss *device, struct dg_faults *faults);

/** Nothing happens until `now`; a moment that is over already is the present one. */
void lx_biss_wire_pause(struct lx_biss_wire *self, dg_ns now);

/** A frame with CDM = 0; what was in it stays in `self`. */
void lx_biss_wire_frame(struct lx_biss_wire *self);

/** What encoder `slave` sent in the last frame. */
struct dg_biss_data lx_biss_wire_data(const struct lx_biss_wire *self, uint8_t slave);

/** Read, or write, `n` registers of encoder `slave` in one control frame.
 * @return how many, or enum lx_biss_failure */
int lx_biss_wire_read(struct lx_biss_wire *self, uint8_t slave, uint8_t address, uint8_t *bytes,
                      size_t n);
int lx_biss_wire_write(struct lx_biss_wire *self, uint8_t slave, uint8_t address,
                       const uint8_t *bytes, size_t n);

/** An enum lx_biss_failure in words. */
const char *lx_biss_failure_text(int failure);

#endif
