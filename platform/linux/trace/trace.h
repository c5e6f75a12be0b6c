/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What went over a wire, in files that other tools open, and in words.
 *
 *   .vcd      RS485: requests and replies, bit for bit in steps of 1 us, a decoded text, sine and
 *             cosine in volts; BiSS and SSI: clock, data, text in steps of 10 ns
 *   .log      CAN: candump -L
 *   .pcapng   CAN: link type SocketCAN, for Wireshark (.pcap means the same)
 *   .csv      INTERBUS: time, IN and OUT words, whenever one has changed
 */
#ifndef DREHGEBER_LINUX_TRACE_H
#define DREHGEBER_LINUX_TRACE_H

#include <stddef.h>

#include "drehgeber/devices.h"
#include "file.h"
#include "say.h"
#include "tap.h"

/** A decoded line of text at most, with its zero. */
#define LX_DECODE_MAX 160u

/**
 * Turns events of one wire into lines: a line for each RS485 frame, CAN frame, note, and INTERBUS
 * cycle with a change. An RS485 frame ends with the next one's first character in the other
 * direction, or with silence; lx_decoder_step() is asked for by time.
 */
struct lx_decoder {
    void (*line)(void *ctx, dg_ns at, bool ours, const char *text); /**< `at`: its first bit */
    void *ctx;
    dg_ns begin; /**< of the frame that is being collected */
    dg_ns last;  /**< end of its last character */
    bool ours;
    uint16_t length;
    uint8_t bytes[140]; /**< the frame; CAN: of each node, the SDO block transfer it is in */
    bool damaged;
    uint32_t baud;
    uint16_t words[1024]; /**< INTERBUS: IN and OUT of the last line */
    uint16_t word_count;
    bool valid;
};

/** Nothing collected. */
void lx_decoder_init(struct lx_decoder *self,
                     void (*line)(void *ctx, dg_ns at, bool ours, const char *text), void *ctx);
/** An event; may give a line. */
void lx_decoder_event(struct lx_decoder *self, const struct dg_tap_event *event);
/** It is `now`: a frame that was followed by silence long enough is given. @return when to call
 * again; DG_NEVER */
dg_ns lx_decoder_step(struct lx_decoder *self, dg_ns now);

/** A trace file. */
struct lx_trace;

struct lx_trace_format;

/** What can be traced of the wires of a protocol. */
struct lx_trace_kind {
    const char *wire;                             /**< for messages, e.g. "RS485" */
    const struct lx_trace_format *const *formats; /**< NULL behind the last */
    bool sincos;                                  /**< there are analog signals beside the wire */
};

/** What a trace is made of. The tap must outlive it. */
struct lx_trace_setup {
    const char *path;               /**< its ending says how */
    const struct lx_folder *folder; /**< of the client that asks; NULL: the user does */
    const struct lx_trace_kind *kind;
    const char *wire; /**< the interface or name that the file shall mention */
    struct lx_tap *tap;
    bool held; /**< nothing on the disk changes before lx_trace_release() */
};

/** Whether there is such a trace of a wire of this kind, by its ending.
 * @return 0, or -1 with one line in `error`: the endings that are right */
int lx_trace_fits(const char *path, const struct lx_trace_kind *kind, struct lx_error *error);

/**
 * Write what the tap tells. Time in the file: of the day for .log and .pcapng, else since the
 * beginning.
 * @return NULL with one line in `error`: an ending that is none for this kind (with those that
 * are), or why it cannot be written
 */
struct lx_trace *lx_trace_open(const struct lx_trace_setup *setup, dg_ns now,
                               struct lx_error *error);

/** What was held back is written, in place of what was in the file; NULL and not held are fine.
 * @return 0, or -1 with one line in `error` */
int lx_trace_release(struct lx_trace *self, struct lx_error *error);

/** End it; NULL is fine. @return 0, or -1 with one line in `error`: what was written is not whole
 */
int lx_trace_close(struct lx_trace *self, struct lx_error *error);

/** Whether it still is written: false after a full disk, which has been said once. */
bool lx_trace_good(const struct lx_trace *self);

#endif
