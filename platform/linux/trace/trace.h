/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What went over a wire, in files that other tools open.
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

#include "drehgeber/words.h"
#include "file.h"
#include "say.h"
#include "tap.h"

/** A trace file. */
struct lx_trace;

struct lx_trace_format;

/** Most formats of a kind of trace. */
#define LX_TRACE_FORMATS 2u

/** What can be traced of the wires of a protocol. */
struct lx_trace_kind {
    const char *title; /**< of the wires, for messages, e.g. "RS485" */
    const struct lx_trace_format *formats[LX_TRACE_FORMATS + 1u]; /**< NULL behind the last */
    bool sincos; /**< there are analog signals beside the wire */
};

/** What a trace is made of. The tap must outlive it. */
struct lx_trace_setup {
    const char *path;               /**< its ending says how */
    const struct lx_folder *folder; /**< of the client that asks; NULL: the user does */
    const struct lx_trace_kind *kind;
    const struct dg_words *words; /**< of the protocol; NULL: it has none */
    const char *wire;             /**< the interface or name that the file shall mention */
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

#endif
