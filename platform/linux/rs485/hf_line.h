/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the RS485 bus: an encoder with its transmitter, and the line that all of them share.
 */
#ifndef DREHGEBER_LINUX_HF_LINE_H
#define DREHGEBER_LINUX_HF_LINE_H

#include "bus.h"
#include "drehgeber/hiperface.h"
#include "hf_settings.h"
#include "image.h"
#include "nvm_writer.h"
#include "serial.h"
#include "timer.h"

/** Opens one kind of port. */
typedef struct lx_serial *lx_serial_open(const struct lx_serial_setup *setup,
                                         struct lx_error *error);

/** Encoders on a line. */
#define LX_HF_DROPS_MAX 32u

/** An encoder with its transmitter. */
struct lx_hf_drop {
    struct lx_station *station;
    struct lx_hf_bus *all;
    struct lx_hf_settings settings;
    struct lx_image image; /**< its EEPROM: */
    struct lx_image_part memory;
    struct {
        uint8_t bytes[DG_HF_FRAME_MAX];
        size_t length; /**< 0: none */
    } held;            /**< a reply that waits until what it acknowledges is on the disk */
    struct dg_hf device;
    struct dg_hf_uart uart; /**< what its line has been told */
    dg_ns deadline;         /**< of the device */
    struct lx_line line;    /**< its reply on the way */
    bool begun;             /**< all at once: it is out already */
    bool again;             /**< it is sent a second time (fault) */
    bool merged;            /**< its present character is lost in another one */
    int flipped;            /**< character that a bit was flipped in (fault), -1: none */
    bool deaf;              /**< inside a request that does not reach it (fault) */
    bool drawn;             /**< the tap knows sine and cosine: */
    int32_t uv[4];
    dg_ns point; /**< they are sampled next */
};

/** The line with 1..32 of them. */
struct lx_hf_bus {
    struct lx_bus bus;
    lx_serial_open *open;
    struct lx_serial *port;
    struct lx_timer timer;
    bool paced;              /**< requests take the time they take on a line */
    struct lx_intake intake; /**< ... and these characters are on it */
    uint64_t overrun;        /**< characters lost since too many were on it */
    dg_ns heard;             /**< end of the master's last character; 0: a reply has come since */
    dg_ns told;              /**< end of the last one that the tap was told of */
    bool mismatch;           /**< the master talks at another speed, and the user has been told */
    uint64_t collided; /**< characters of the master that came in while a reply was on the line */
    bool sampling;     /**< somebody asked for sine and cosine when it was looked last */
    const char *names[LX_HF_DROPS_MAX];
    size_t count;
    struct lx_hf_drop drop[];
};

/** The setting of a line as its port knows it. */
static inline struct lx_uart lx_hf_uart(const struct dg_hf_uart *uart)
{
    return (struct lx_uart){uart->baud, uart->parity};
}

/** Whether it has power. */
bool lx_hf_powered(const struct lx_hf_drop *self);

/** The faults it has. */
static inline struct dg_faults *lx_hf_faults(const struct lx_hf_drop *self)
{
    return &self->station->control.faults;
}

/* --- replies, hf_reply.c --- */

/** Of the device: operations with the struct lx_hf_drop as ctx. */
extern const struct dg_hf_ops lx_hf_device_ops;

/** What its file was sent is there, or lost; `ctx` is the struct lx_hf_drop. */
void lx_hf_on_settled(void *ctx, dg_ns now);

/** Whether a reply of it is on the line at `now`. */
bool lx_hf_sends(const struct lx_hf_drop *self, dg_ns now);

/** Whether it is busy with a reply, also with one that is held back: then it hears nothing. */
bool lx_hf_is_busy(const struct lx_hf_drop *self, dg_ns now);

/** When something happens to its reply next; DG_NEVER. */
dg_ns lx_hf_reply_next(const struct lx_hf_drop *self);

/** What is due with it at `at`. */
void lx_hf_reply_go_on(struct lx_hf_drop *self, dg_ns at);

/* --- the line, hf_line.c --- */

/** A character of `from` is over: everybody else has heard it. */
void lx_hf_spread(struct lx_hf_drop *from, dg_ns at, const struct lx_character *character);

/** After every call into the device: its next deadline, and the setting it may have changed. */
void lx_hf_follow(struct lx_hf_drop *self, dg_ns deadline);

/** After everything else: what is on the line goes on, and the timer is set. */
void lx_hf_settle(struct lx_hf_bus *self);

/** Tell the tap of sine and cosine up to `now`, if anybody asks. @return when to call again */
dg_ns lx_hf_sample(struct lx_hf_bus *self, dg_ns now);

/** The timer; `ctx` is the bus. */
void lx_hf_on_time(void *ctx, dg_ns now);

/** The port has a character of the master; `ctx` is the bus. */
void lx_hf_on_character(void *ctx, dg_ns now, const struct lx_character *character);

#endif
