/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A Modbus/TCP bus coupler on the event loop: its clients, and the timer of its ring.
 */
#ifndef DREHGEBER_LINUX_MODBUS_H
#define DREHGEBER_LINUX_MODBUS_H

#include <modbus/modbus.h>
#include <systemd/sd-event.h>

#include "drehgeber/ring_coupler.h"
#include "drehgeber/ring_master.h"
#include "peers.h"
#include "timer.h"

/** Longest request: 7 bytes of header and 253 of function and data. */
#define LX_MODBUS_ADU_MAX 260u

/** What a coupler is made of. Everything pointed to must outlive it. */
struct lx_modbus_setup {
    sd_event *event;
    const struct lx_say *say;
    const char *where;             /**< HOST:PORT[,open]; port 0: any */
    struct dg_ring_master *master; /**< of its ring */
    bool tear;                     /**< half of an OUT word may be written */
};

/** A coupler. Not to be moved. */
struct lx_modbus {
    struct lx_modbus_setup setup;
    struct dg_ib_coupler map;
    struct lx_timer timer;
    modbus_t *protocol;
    struct lx_peers_where where;
    struct lx_peers peers;
    uint64_t requests; /**< answered */
    uint16_t
        registers[DG_IB_COUPLER_END]; /**< what the protocol reads and writes during a request */
};

/** Listen, and cycle from the first turn of the loop on. @return 0, or -1 with `error`, then close
 */
int lx_modbus_open(struct lx_modbus *self, const struct lx_modbus_setup *setup,
                   struct lx_error *error);

/** Somebody else has looked at the ring or done something to it, and to its master: sleep until a
 * cycle does something by itself. */
void lx_modbus_sleep(struct lx_modbus *self);

/** Close all connections; also after a failed open. */
void lx_modbus_close(struct lx_modbus *self);

/** Whether `where` is HOST:PORT or HOST:PORT,open. @return 0, or -1 with `error` */
int lx_modbus_check(const char *where, struct lx_error *error);

#endif
