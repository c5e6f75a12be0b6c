/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A Modbus/TCP bus coupler on the event loop: its clients, its registers, and the cycle of its
 * ring.
 */
#ifndef DREHGEBER_LINUX_MODBUS_H
#define DREHGEBER_LINUX_MODBUS_H

#include <modbus/modbus.h>
#include <systemd/sd-event.h>

#include "modbus_map.h"
#include "modbus_time.h"
#include "peers.h"
#include "timer.h"

/** Longest request: 7 bytes of header and 253 of function and data. */
#define LX_MODBUS_ADU_MAX 260u

/** What a coupler is made of. Everything pointed to must outlive it. */
struct lx_modbus_setup {
    sd_event *event;
    const struct lx_say *say;
    const char *where; /**< HOST:PORT[,open]; port 0: any */
    struct lx_ring *ring;
    dg_ns cycle; /**< from one cycle of the ring to the next */
    bool tear;   /**< half of an OUT word may be written */
    /** A cycle is due at `now`, which may be over: drive the ring. */
    void (*drive)(void *ctx, dg_ns now);
    void *ctx;
};

/** A coupler. Not to be moved. */
struct lx_modbus {
    struct lx_modbus_setup setup;
    struct lx_map map;
    struct lx_timer timer;
    struct lx_ring_time time;
    modbus_t *protocol;
    struct lx_peers_where where;
    struct lx_peers peers;
    uint64_t requests;              /**< answered */
    uint16_t registers[LX_MAP_END]; /**< what the protocol reads and writes during a request */
};

/** Listen, and cycle from the first turn of the loop on. @return 0, or -1 with `error`, then close
 */
int lx_modbus_open(struct lx_modbus *self, const struct lx_modbus_setup *setup,
                   struct lx_error *error);

/** Before anybody but a client of Modbus looks at the ring or does something to it. */
void lx_modbus_look(struct lx_modbus *self, dg_ns now);

/** Something was done to it at `now`, and it is watched or not from then on. */
void lx_modbus_stir(struct lx_modbus *self, bool watched, dg_ns now);

/** While drive() runs: the ring is not watched from the next cycle on. */
void lx_modbus_unwatch(struct lx_modbus *self);

/** Close all connections; also after a failed open. */
void lx_modbus_close(struct lx_modbus *self);

/** Whether `where` is HOST:PORT or HOST:PORT,open. @return 0, or -1 with `error` */
int lx_modbus_check(const char *where, struct lx_error *error);

#endif
