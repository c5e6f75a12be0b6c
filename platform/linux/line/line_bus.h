/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of a line of characters: a port of the machine, and the bus of the library that its
 * characters go to and come from.
 */
#ifndef DREHGEBER_LINUX_LINE_BUS_H
#define DREHGEBER_LINUX_LINE_BUS_H

#include "bus.h"
#include "drehgeber/bus_characters.h"
#include "drehgeber/host_wire.h"
#include "serial.h"
#include "timer.h"

/** Encoders on a line. */
#define LX_LINE_ENCODERS_MAX 32u

/** An encoder on it. */
struct lx_line_encoder {
    struct lx_station *station;
    struct lx_line_bus *all;
    dg_ns sincos; /**< in a trace: time between samples; 0: none */
    bool drawn;   /**< the tap knows sine and cosine: */
    int32_t uv[4];
    dg_ns point; /**< they are sampled next */
};

/** The line with 1..32 of them. */
struct lx_line_bus {
    struct lx_bus bus;
    struct lx_serial *port;
    struct lx_timer timer;
    bool paced;    /**< requests take the time they take on a line */
    dg_ns told;    /**< end of the last character that the tap was told of */
    bool mismatch; /**< the master talks at another speed, and the user has been told */
    bool sampling; /**< somebody asked for sine and cosine when it was looked last */
    const char *names[LX_LINE_ENCODERS_MAX];
    size_t count;
    struct lx_line_encoder encoder[];
};

/** The setting of a line as its port knows it. */
static inline struct lx_uart lx_line_uart(const struct dg_host_uart *uart)
{
    return (struct lx_uart){uart->baud, (char)uart->parity};
}

/* --- the master, line_master.c --- */

/** The door of the bus: `ctx` is the struct lx_line_bus. */
extern const struct dg_bus_ops lx_line_ops;

/** Its struct dg_characters_setup.whole, likewise: a UART does the timing. */
void lx_line_whole(void *ctx, size_t place, dg_ns at, const uint8_t *bytes, size_t n);

/** Before the library is called: does anybody look? */
void lx_line_enter(struct lx_line_bus *self);

/** After everything else: the port has the first encoder's setting, and the timer is set; `next`:
 * when the library is to be called again. */
void lx_line_settle(struct lx_line_bus *self, dg_ns next);

/** The timer; `ctx` is the bus. */
void lx_line_on_time(void *ctx, dg_ns now);

/** The port has a character of the master; `ctx` is the bus. */
void lx_line_on_character(void *ctx, dg_ns now, const struct lx_character *character);

/** What its file was sent is there, or lost; `ctx` is the struct lx_line_encoder. */
void lx_line_on_settled(void *ctx, dg_ns now);

/* --- line_sincos.c --- */

/** Tell the tap of sine and cosine up to `now`, if anybody asks. @return when to call again */
dg_ns lx_line_sample(struct lx_line_bus *self, dg_ns now);

#endif
