/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The master of a simulated BiSS wire. What it does, and what the encoders say to it, goes to a
 * tap.
 */
#ifndef DREHGEBER_LINUX_SIM_MASTER_H
#define DREHGEBER_LINUX_SIM_MASTER_H

#include "biss_wire.h"
#include "tap.h"

/** A master. Not to be moved. */
struct lx_sim_master {
    struct lx_biss_wire wire;
    const struct lx_tap *tap;
    const char *name[DG_BISS_CHAIN_MAX]; /**< of the encoders */
};

/** A wire without encoders at `now`. `tap` must outlive it. */
void lx_sim_master_init(struct lx_sim_master *self, const struct lx_tap *tap,
                        const struct lx_biss_timing *timing, dg_ns now);

/** Put an encoder behind the others, as lx_biss_wire_add(). `name` says which one it is where there
 * are several; borrowed. */
void lx_sim_master_add(struct lx_sim_master *self, struct dg_biss *device, struct dg_faults *faults,
                       const char *name);

/** Nothing happens until `now`, as lx_biss_wire_pause(). */
void lx_sim_master_pause(struct lx_sim_master *self, dg_ns now);

/** A frame with CDM = 0, as lx_biss_wire_frame(). */
void lx_sim_master_frame(struct lx_sim_master *self);

/** Read, or write, `n` registers of encoder `slave` in as many control frames as it takes: a
 * sequence ends where the next register is refused.
 * @param done how many registers were accessed
 * @return what is not negative, or enum lx_biss_failure for register `address` + `done` */
int lx_sim_master_read(struct lx_sim_master *self, uint8_t slave, uint8_t address, uint8_t *bytes,
                       size_t n, size_t *done);
int lx_sim_master_write(struct lx_sim_master *self, uint8_t slave, uint8_t address,
                        const uint8_t *bytes, size_t n, size_t *done);

/** An access to `address` that ended in `failure`, in words: "register 78h: ...". */
void lx_sim_master_explain(const struct lx_sim_master *self, uint8_t slave, uint8_t address,
                           int failure, char *to, size_t size);

#endif
