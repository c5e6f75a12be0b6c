/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A serial port on the event loop: characters in, characters out. Four kinds: a pseudo-terminal
 * (pty.c), a real UART (tty.c), a TCP port (net_port.c) and topics of a SIL Kit simulation
 * (silkit_serial.c). One that has gone is looked for once a second.
 */
#ifndef DREHGEBER_LINUX_SERIAL_H
#define DREHGEBER_LINUX_SERIAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "say.h"
#include "timer.h"
#include "uart.h"

/** Longest address of a port: a path. */
#define LX_ADDRESS_MAX 4096u

/** Bytes read at once; a flood is taken in pieces of this, between which deadlines get their turn.
 */
#define LX_SERIAL_CHUNK 4096u

/** lx_serial.baud where nobody can tell, or nobody asks: right for everybody. */
#define LX_BAUD_ANY UINT32_MAX

/** A received character. */
struct lx_character {
    uint8_t byte;
    bool damaged; /**< parity or framing error, or sent with another setting */
};

/** Decoder of what a tty gives with INPCK|PARMRK: FF 00 c is a damaged c, FF FF an intact FF. */
struct lx_parmrk {
    uint8_t seen; /**< bytes of an escape seen so far, 0..2 */
};

/** @return true when `byte` completes a character, which is in `out` then */
bool lx_parmrk_feed(struct lx_parmrk *self, uint8_t byte, struct lx_character *out);

struct lx_serial;
struct lx_silkit;

/** What a kind of port does in its own way. */
struct lx_serial_ops {
    const char *again; /**< what is done about one that has gone, for the message */
    /** Open files, make links, call lx_serial_watch(); also when it is to be back. The first time
     * all of its struct is zero but the shared part.
     * @return 0, or -1 with `error`; then shut() cleans up, and self->fd is closed */
    int (*open)(struct lx_serial *self, struct lx_error *error);
    /** The line's UART setting has changed to self->uart. NULL: nobody to tell. */
    void (*apply)(struct lx_serial *self);
    /** Send what there is room for. @return how many bytes. NULL: they are written to self->fd. */
    size_t (*send)(struct lx_serial *self, const uint8_t *bytes, size_t n);
    /** read() gave `n` bytes at `now`: fill in self->baud and self->parity.
     * @return how many of them stand before the characters */
    size_t (*received)(struct lx_serial *self, dg_ns now, const uint8_t *bytes, size_t n);
    /** @return whether `byte` completes a character, which is in `out` then. NULL: each is one. */
    bool (*decode)(struct lx_serial *self, uint8_t byte, struct lx_character *out);
    /** Whether what appears under this address again is the same port. NULL: it is. */
    bool (*lasting)(const struct lx_serial *self);
    /** Undo open(), but for self->fd. NULL: nothing. */
    void (*shut)(struct lx_serial *self);
};

/** What a port is made of. Everything pointed to must outlive it. */
struct lx_serial_setup {
    sd_event *event;
    struct lx_silkit *silkit; /**< the rig in a simulation, for a line of one */
    const struct lx_say *say;
    const char *where;   /**< device, link or TCP port; NULL: a link is not wanted */
    struct lx_uart uart; /**< setting in force */
    uint32_t found_baud; /**< what a pty is set to, for a master that does not set it */
    bool any_line;       /**< nobody asks for the data rate of a pty's master */
    /** A character came in at `now`. */
    void (*rx)(void *ctx, dg_ns now, const struct lx_character *character);
    /** It was gone and is back; a pty has another address. NULL: nobody to tell. */
    void (*back)(void *ctx);
    void *ctx;
};

/** Things nobody has to act on; they only count up. */
struct lx_serial_counters {
    uint64_t lost; /**< characters that nobody took */
};

/** The part that all kinds share; first member of each kind. */
struct lx_serial {
    const struct lx_serial_ops *ops;
    struct lx_serial_setup setup;
    struct lx_uart uart;  /**< the line's setting */
    struct lx_uart sends; /**< that of who sends next, as several may be on a line; LX_BAUD_ANY and
                             parity 0: right for everybody */
    bool timed;           /**< a UART does the timing: characters are put at once */
    int fd;               /**< -1 while the port is gone */
    sd_event_source *io;
    bool paused;
    uint8_t chunk[LX_SERIAL_CHUNK]; /**< read, and not yet handed to setup.rx(): */
    size_t first;
    size_t count;
    struct lx_timer reopen;
    struct lx_serial_counters counters;
    char address[LX_ADDRESS_MAX]; /**< what a master opens */

    /* of the character that is being handed to setup.rx() */
    uint32_t baud; /**< it was sent at; LX_BAUD_ANY; 0: none of the standard ones */
    char parity;   /**< likewise, 0: the port cannot tell */
    size_t more;   /**< characters that came in with it and follow; with escapes an estimate */
};

/** Make a pty. @return NULL with one line in `error` */
struct lx_serial *lx_pty_open(const struct lx_serial_setup *setup, struct lx_error *error);

/** Open a UART. @return NULL with one line in `error` */
struct lx_serial *lx_tty_open(const struct lx_serial_setup *setup, struct lx_error *error);

/** Listen for TCP clients. @return NULL with one line in `error` */
struct lx_serial *lx_net_port_open(const struct lx_serial_setup *setup, struct lx_error *error);

/** Join the simulation. @return NULL with one line in `error` */
struct lx_serial *lx_silkit_serial_open(const struct lx_serial_setup *setup,
                                        struct lx_error *error);

/** Whether `where` is an address of a TCP port. @return 0, or -1 with `error` */
int lx_net_port_check(const char *where, struct lx_error *error);

/** Close any of them; NULL is fine. */
void lx_serial_close(struct lx_serial *self);

/** The UART setting is `uart` now. */
void lx_serial_set(struct lx_serial *self, const struct lx_uart *uart);

/** Whether the port is there; one that has gone is looked for. */
bool lx_serial_up(const struct lx_serial *self);

/** Hand over no characters, also none of those that have been read, or go on. */
void lx_serial_pause(struct lx_serial *self, bool paused);

/** Send as much as there is room for now. @return how many bytes */
size_t lx_serial_send(struct lx_serial *self, const uint8_t *bytes, size_t n);

/** Send. Does not block; what nobody takes is lost and counted. */
void lx_serial_put(struct lx_serial *self, const uint8_t *bytes, size_t n);

/** For the kinds: make and open one, whose struct has `size` bytes. @return NULL with one line in
 * `error` */
struct lx_serial *lx_serial_make(const struct lx_serial_ops *ops, size_t size,
                                 const struct lx_serial_setup *setup, struct lx_error *error);

/** For the kinds: put self->fd on the event loop. @return 0 or a negative errno */
int lx_serial_watch(struct lx_serial *self);

/** The number of a termios speed; 0 when it is none of the standard ones. */
uint32_t lx_baud_of_speed(unsigned long speed);

/** The termios speed of a number; 0 when there is none. */
unsigned long lx_speed_of_baud(uint32_t baud);

#endif
