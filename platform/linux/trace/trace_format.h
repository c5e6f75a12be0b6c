/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of trace files: what their formats share.
 */
#ifndef DREHGEBER_LINUX_TRACE_FORMAT_H
#define DREHGEBER_LINUX_TRACE_FORMAT_H

#include <stdio.h>

#include "trace.h"

/** Longest name of a wire in a file, with its zero: that of a network interface. */
#define LX_TRACE_WIRE_MAX 16u

/** How a kind of file is written. Errors of `file` are seen by the caller, after each call. */
struct lx_trace_format {
    const char *ending;
    const char *also;                     /**< an ending that means the same; NULL: none does */
    struct lx_file_mark mark;             /**< n 0: none */
    size_t size;                          /**< of the format's own state */
    void (*begin)(struct lx_trace *self); /**< NULL: nothing, likewise `end` */
    void (*event)(struct lx_trace *self, const struct dg_tap_event *event);
    void (*end)(struct lx_trace *self); /**< what was held back */
    const char *scope;                  /**< of a clocked line: what is traced, */
    const char *lines[2];               /**< ... names of clock and data */
};

/** A file while it is written. */
struct lx_trace {
    const struct lx_trace_format *format;
    FILE *file;
    struct lx_file *held; /**< NULL: no more */
    char *path;
    struct lx_tap *tap;
    struct lx_tap_listener listener;
    char wire[LX_TRACE_WIRE_MAX]; /**< letters, digits, `-`, `_` and `.` only */
    dg_ns opened;
    dg_ns flushed;
    uint64_t day_ns; /**< time of the day at the tap's 0, since 1970-01-01 UTC, modulo 2^64 */
    bool good;
    int reason;                   /**< errno of what went wrong */
    void *own;                    /**< the format's */
    const struct dg_words *words; /**< of the protocol; NULL: it has none */
    void *memory;                 /**< theirs, for a format that asks them */
};

/** How a VCD file begins. */
#define LX_VCD_BEGIN "$comment drehgeber:"
#define LX_VCD_MARK                                                                                \
    {                                                                                              \
        0, sizeof LX_VCD_BEGIN - 1u, LX_VCD_BEGIN                                                  \
    }

/** The formats. */
extern const struct lx_trace_format lx_trace_uart, lx_trace_log, lx_trace_pcapng, lx_trace_csv;

/** Texts of a VCD file that wait for their turn. */
#define LX_VCD_TEXTS 16u

/** What a VCD file has. Readers that take samples take one for each step, over hours of silence,
 * too: a step is as long as the wire's edges allow. */
struct lx_vcd_head {
    const char *scope;
    dg_ns step_ns;        /**< 1, 10 or 100 ns, us or ms */
    const char *ids;      /**< of the signals, a letter each */
    const char *names[2]; /**< theirs */
};

/** A VCD file: time never goes back, so that a text which begins earlier is to be put in first. */
struct lx_vcd {
    FILE *file;
    dg_ns step_ns;
    dg_ns at; /**< of what was written last */
    size_t count;
    struct {
        dg_ns at;
        char text[DG_WORDS_MAX];
    } texts[LX_VCD_TEXTS];
};

/** Lines of an encoder with sine and cosine. */
#define LX_VCD_SINCOS 4u

/** All signals are high at time 0; besides there are sine and cosine of the tap's encoders, in
 * volts. */
void lx_vcd_begin(struct lx_vcd *self, const struct lx_trace *trace,
                  const struct lx_vcd_head *head);

/** A level from `at` on, and before it the texts up to then. */
void lx_vcd_level(struct lx_vcd *self, dg_ns at, char id, bool level);

/** Sine and cosine of an encoder from `at` on, in microvolts, and before it the texts up to then.
 */
void lx_vcd_sincos(struct lx_vcd *self, dg_ns at, size_t encoder, const int32_t uv[LX_VCD_SINCOS]);

/** A text from `at` on. */
void lx_vcd_text(struct lx_vcd *self, dg_ns at, const char *text);

/** All texts up to `at` are written. */
void lx_vcd_advance(struct lx_vcd *self, dg_ns at);

/** All texts are written, and the end of the last level. */
void lx_vcd_end(struct lx_vcd *self);

/** Levels of a clocked line that are held back: some frames. */
#define LX_TRACE_HELD 1024u

/** A level that is held back. */
struct lx_trace_held {
    dg_ns at;
    char id;
    bool level;
};

/** A clocked line in a VCD file. */
struct lx_trace_clocked {
    struct lx_vcd vcd;
    bool clock;
    bool data;
    bool begun; /**< there was an event */
    size_t first;
    size_t count;
    struct lx_trace_held held[LX_TRACE_HELD];
};

/** As in struct lx_trace_format. */
void lx_trace_clocked_begin(struct lx_trace *self);
void lx_trace_clocked_event(struct lx_trace *self, const struct dg_tap_event *event);
void lx_trace_clocked_end(struct lx_trace *self);

/** The format of a protocol: what is traced, names of clock and data. */
#define LX_TRACE_CLOCKED(what, clock_name, data_name)                                              \
    {                                                                                              \
        .ending = ".vcd", .mark = LX_VCD_MARK, .size = sizeof(struct lx_trace_clocked),            \
        .begin = lx_trace_clocked_begin, .event = lx_trace_clocked_event,                          \
        .end = lx_trace_clocked_end, .scope = (what), .lines = {                                   \
            (clock_name),                                                                          \
            (data_name)                                                                            \
        }                                                                                          \
    }

#endif
