/* SPDX-License-Identifier: MIT */
/*
 * Clock and data of a real encoder on two GPIO lines, in real time: this host is the master.
 *
 *   clock  ¯¯¯¯¯¯|_____|¯¯¯¯¯|_____
 *   data          ^look       ^look
 *
 * An edge is made when it is due, or as soon as this host gets to it. How late it was at worst says
 * whether an answer that is wrong is the encoder's.
 */
#ifndef DREHGEBER_TOOL_VERIFY_LINES_H
#define DREHGEBER_TOOL_VERIFY_LINES_H

#include <stdbool.h>

#include "drehgeber/time.h"
#include "error.h"
#include "gpio_lines.h"

/* Half a period of the slowest clock that is tried. */
#define VERIFY_HALF_MAX DG_MS(8)
/* Up to this one an encoder has its own timeouts; beyond it there is none but our own. */
#define VERIFY_HALF_FAST DG_US(5)
/* Longest time for which data of an encoder that is asked nothing is low. */
#define VERIFY_REST_MAX DG_MS(200)

struct verify_lines {
    struct lx_gpio_lines *gpio; /* NULL: closed */
    dg_ns half;                 /* a period of the clock */
    dg_ns now;                  /* of the latest edge or look */
    dg_ns edge;                 /* of the latest edge, or of verify_lines_begin() */
    dg_ns late;                 /* the latest that an edge was since verify_lines_begin() */
    bool gone;                  /* they cannot be used any more: data is low */
};

/* CHIP:CLOCK,DATA; the clock is high. 0, or -1 with `error` */
int verify_lines_open(struct verify_lines *self, const char *where, struct lx_error *error);

/* The next slower clock, as the encoder has not followed this one. False: there is none. */
bool verify_lines_slow_down(struct verify_lines *self);

/* The encoder has followed this clock. One that follows slowly gets twice the time that it needed. */
void verify_lines_settle(struct verify_lines *self);

/* From now on it counts how late this host is. */
void verify_lines_begin(struct verify_lines *self);

/* Whether it was so late since then that an encoder may have ended its frame. */
bool verify_lines_torn(const struct verify_lines *self);

/* The clock goes to `level` at `at`. */
void verify_lines_clock(struct verify_lines *self, dg_ns at, bool level);

/* Data at `at`. */
bool verify_lines_data(struct verify_lines *self, dg_ns at);

/* Wait until data is high, as it is between frames. False: it stays low for VERIFY_REST_MAX. */
bool verify_lines_rest(struct verify_lines *self);

void verify_lines_close(struct verify_lines *self);

#endif
