/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The registers of a Modbus coupler in front of a ring of INTERBUS encoders, on a master of the
 * ring (ring_master.h). Ranges of registers and values go in and out; the host has the protocol that
 * carries them, and the connections. Addresses follow the publicly documented layout of Modbus
 * couplers for fieldbus terminals. An object of its own, that an image without it does not carry.
 *
 *   dg_ib_coupler_init(&coupler, &master, false)
 *   dg_ib_coupler_request(&coupler, now)       behind each request's arrival
 *   if dg_ib_coupler_readable(): dg_ib_coupler_read(), likewise to write
 */
#ifndef DREHGEBER_RING_COUPLER_H
#define DREHGEBER_RING_COUPLER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/interbus.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_ring_master; /* ring_master.h */

/** No register is at or above this address. */
#define DG_IB_COUPLER_END (0x2000u + 16u * DG_IB_RING_MAX)

/** A coupler. Only this module writes its fields, but for `tear`. */
struct dg_ib_coupler {
    struct dg_ring_master *master;
    bool tear;            /**< half of an OUT word may be written (I21) */
    uint16_t fed_by_each; /**< 1: each request feeds the watchdog; 0: only writes of OUT do */
    uint16_t key;         /**< last value written to 1121h */
    dg_ns now;            /**< of the request */
};

/** A range of registers. */
struct dg_ib_registers {
    uint16_t first;
    uint16_t count;
};

/** The registers of the encoders on the master's ring, each of which was switched on once. Each
 * request feeds the watchdog, which is off. */
DG_API void dg_ib_coupler_init(struct dg_ib_coupler *self, struct dg_ring_master *master,
                               bool tear);

/** A request came in at `now`, before it is looked at: the ring is what it has come to by then. */
DG_API void dg_ib_coupler_request(struct dg_ib_coupler *self, dg_ns now);

/** Whether every register of the range exists. */
DG_API bool dg_ib_coupler_readable(const struct dg_ib_coupler *self, struct dg_ib_registers range);

/** Whether every register of the range may be written, and no OUT word in part (I21). */
DG_API bool dg_ib_coupler_writable(const struct dg_ib_coupler *self, struct dg_ib_registers range);

/** Read a readable range; a register that does not exist is 0. */
DG_API void dg_ib_coupler_read(const struct dg_ib_coupler *self, struct dg_ib_registers range,
                               uint16_t *to);

/** Write a writable range. @return false: a value is out of range, or a register cannot be written;
 * nothing was */
DG_API bool dg_ib_coupler_write(struct dg_ib_coupler *self, struct dg_ib_registers range,
                                const uint16_t *values);

/** Describe the registers of a ring of these models, a line at a time, which lasts no longer than
 * the call. */
DG_API void dg_ib_coupler_describe(const struct dg_ib_model *const *models, size_t count,
                                   void (*line)(void *ctx, const char *text), void *ctx);

#ifdef __cplusplus
}
#endif

#endif
