/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A serial line on the event loop: characters in, replies out, half duplex. Two kinds: a
 * pseudo-terminal (pty.c) and a real UART (tty.c).
 */
#ifndef DREHGEBER_LINUX_SERIAL_H
#define DREHGEBER_LINUX_SERIAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "drehgeber/hiperface.h"
#include "line.h"
#include "say.h"
#include "timer.h"

/** Longest address of a line: a path. */
#define LX_ADDRESS_MAX 4096u

struct lx_serial;

/** What a kind of line does in its own way. */
struct lx_serial_ops {
    /** The device's UART setting has changed to self->uart. NULL: nobody to tell. */
    void (*apply)(struct lx_serial *self);
    /** Decode `n` bytes that read() gave at `now` and hand them to lx_serial_rx(). */
    void (*received)(struct lx_serial *self, dg_ns now, const uint8_t *bytes, size_t n);
    /** The line has gone: `reason` is an errno, 0 for a hang-up. */
    void (*gone)(struct lx_serial *self, int reason);
    /** Close files, remove links. */
    void (*close)(struct lx_serial *self);
};

/** How a reply gets out. */
enum lx_pace {
    LX_PACE_TIMER, /**< a character at a time, each at the end of its stop bit */
    LX_PACE_UART,  /**< at once, a UART does the timing */
    LX_PACE_NONE,  /**< at once, and it takes no time */
};

/** What a line is made of. Everything pointed to must outlive it. */
struct lx_serial_setup {
    sd_event *event;
    const struct lx_say *say;
    const char *where;        /**< device or link; NULL: a link is not wanted */
    struct dg_hf_uart uart;   /**< setting in force */
    struct dg_hf_uart stored; /**< setting in force when the start-up window is over */
    bool pace;                /**< replies take their time on the line */
    bool any_line;            /**< a pty takes any speed as the right one */
    /** A character came in at `now`; `flags` are enum dg_hf_rx_flags. */
    void (*rx)(void *ctx, dg_ns now, const struct lx_character *character);
    void *ctx;
};

/** Things nobody has to act on; they only count up. */
struct lx_serial_counters {
    uint64_t collided; /**< characters that came in while a reply was on the line; dropped */
    uint64_t lost;     /**< characters of replies that nobody took */
};

/** The part that all kinds share; first member of each kind. */
struct lx_serial {
    const struct lx_serial_ops *ops;
    struct lx_serial_setup setup;
    struct dg_hf_uart uart; /**< the device's setting */
    enum lx_pace pace;
    int fd; /**< -1 while the line is gone */
    sd_event_source *io;
    struct lx_timer timer; /**< of the next character */
    struct lx_line line;
    struct lx_serial_counters counters;
    char address[LX_ADDRESS_MAX]; /**< what a master opens */
};

/** Make a pty. @return NULL with one line in `error` */
struct lx_serial *lx_pty_open(const struct lx_serial_setup *setup, struct lx_error *error);

/** Open a UART. @return NULL with one line in `error` */
struct lx_serial *lx_tty_open(const struct lx_serial_setup *setup, struct lx_error *error);

/** Close any of them; NULL is fine. */
void lx_serial_close(struct lx_serial *self);

/** The device's UART setting is `uart` now. */
void lx_serial_set(struct lx_serial *self, const struct dg_hf_uart *uart);

/** Send a reply that starts now. Does not block; what nobody takes is lost and counted. */
void lx_serial_send(struct lx_serial *self, dg_ns now, const uint8_t *bytes, size_t n);

/** For the kinds: fill the shared part. @return 0, or -1 with `error` */
int lx_serial_init(struct lx_serial *self, const struct lx_serial_ops *ops,
                   const struct lx_serial_setup *setup, struct lx_error *error);

/** For the kinds: put self->fd on the event loop. @return 0 or a negative errno */
int lx_serial_watch(struct lx_serial *self);

/** For the kinds: take self->fd off the event loop and close it. */
void lx_serial_unwatch(struct lx_serial *self);

/** For the kinds: a character came in. */
void lx_serial_rx(struct lx_serial *self, dg_ns now, const struct lx_character *character);

/** The number of a termios speed; 0 when it is none of the standard ones. */
uint32_t lx_baud_of_speed(unsigned long speed);

/** The termios speed of a number; 0 when there is none. */
unsigned long lx_speed_of_baud(uint32_t baud);

#endif
