/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the master of a simulated wire with BiSS encoders can do besides reading frames: control
 * frames, that is registers.
 */
#ifndef DREHGEBER_LINUX_BISS_MASTER_H
#define DREHGEBER_LINUX_BISS_MASTER_H

#include <stddef.h>
#include <stdint.h>

#include "bus.h"
#include "sim_master.h"

/** What an access can end in; what is not negative counts registers. */
enum lx_biss_failure {
    LX_BISS_SILENT = -1,   /**< the encoder did not answer */
    LX_BISS_REFUSED = -2,  /**< register not implemented, protected, or not ready */
    LX_BISS_TOO_BUSY = -3, /**< longer than 20 ms */
    LX_BISS_DAMAGED = -4,  /**< a check sum is wrong */
};

/** Read, or write, `n` registers of encoder `slave` in as many control frames as it takes: a
 * sequence ends where the next register is refused.
 * @param done how many registers were accessed
 * @return what is not negative, or enum lx_biss_failure for register `address` + `done` */
int lx_biss_master_read(struct lx_sim_master *self, uint8_t slave, uint8_t address, uint8_t *bytes,
                        size_t n, size_t *done);
int lx_biss_master_write(struct lx_sim_master *self, uint8_t slave, uint8_t address,
                         const uint8_t *bytes, size_t n, size_t *done);

/** An enum lx_biss_failure in words. */
const char *lx_biss_failure_text(int failure);

/** BISS:... of a simulated wire, as lx_clocked_protocol.offer(). */
void lx_biss_master_offer(struct lx_station *station);

#endif
