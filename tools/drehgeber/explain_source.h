/* SPDX-License-Identifier: MIT */
/*
 * A recording as a stream of events, and the bounded reader of lines that its formats share. No
 * reader keeps more than a line, a packet or a character for each side, however long the file is.
 */
#ifndef DREHGEBER_TOOL_EXPLAIN_SOURCE_H
#define DREHGEBER_TOOL_EXPLAIN_SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "drehgeber/host.h"
#include "drehgeber/stack.h"
#include "drehgeber/tap.h"
#include "error.h"

/* Longest line of a text, with its end. */
#define EXPLAIN_LINE_MAX 4096u

/* A text, line by line. */
struct explain_text {
    FILE *file;
    const char *path;
    uint64_t offset;   /* of `line` in the file */
    const char *line;  /* without its end, with a zero behind it */
    const char *token; /* where the next one of this line begins */
    size_t begin;      /* of what is not used yet, in `room` */
    size_t end;
    bool over; /* of the file */
    char room[2u * EXPLAIN_LINE_MAX];
};

/* The next line. @return 1; 0: the file is over; -1 with `error`: it is too long, or no text */
int explain_text_next(struct explain_text *self, struct lx_error *error);

/* The next word of the line: between blanks. @return its length; 0: there is none */
size_t explain_text_token(struct explain_text *self, const char **token);

/* "FILE:OFFSET: what; right": it is about the byte at `at` of the line. Always -1. */
int explain_text_refuse(const struct explain_text *self, const char *at, const char *what,
                        const char *right, struct lx_error *error);

/* A decimal number of up to 18 digits. @return characters; 0: there is none */
size_t explain_number(const char *at, size_t n, uint64_t *value);

/* Seconds with up to 9 decimals, in ns. @return characters; 0: there is none */
size_t explain_seconds(const char *at, size_t n, dg_ns *value);

/* Hexadecimal digits, 16 at most. @return characters; 0: there are none */
size_t explain_hex(const char *at, size_t n, uint64_t *value);

struct explain_source;

/* A format. */
struct explain_format {
    const char *name; /* for messages */
    /* Whether a file begins so. */
    bool (*begins)(const uint8_t *bytes, size_t n);
    size_t size; /* of struct explain_source and what follows it */
    /* NULL: there is nothing to do. @return 0, or -1 with `error` */
    int (*open)(struct explain_source *self, struct lx_error *error);
    /* The next event; a moment is never before the one of the last event.
       @return 1; 0: the file is over; -1 with `error`, whose line begins with FILE:OFFSET */
    int (*next)(struct explain_source *self, struct dg_tap_event *to, struct lx_error *error);
    void (*close)(struct explain_source *self); /* NULL: nothing */
};

/* A recording that is being read; first member of a format's own. */
struct explain_source {
    const struct explain_format *format;
    struct explain_text text; /* with the file and its path for any format */
    dg_ns now;                /* of the last event */
    bool sided;               /* the format says who sends; else the events do by what they are */
    struct dg_host_uart uart; /* of a line that does not say it: as whoever opens it knows */
    uint64_t left_out;        /* frames that none of these encoders has: extended ones, CAN FD */
};

extern const struct explain_format explain_candump, explain_serial, explain_pcap, explain_sr,
    explain_vcd;

/* All of them. */
extern const struct explain_format *const explain_formats[];
extern const size_t explain_format_count;

/* Read a recording, which is what its first bytes say. `file` is the caller's, and must outlive it.
   @return NULL with `error` */
struct explain_source *explain_source_open(FILE *file, const char *path, struct lx_error *error);

int explain_source_next(struct explain_source *self, struct dg_tap_event *to,
                        struct lx_error *error);

/* NULL is fine. */
void explain_source_close(struct explain_source *self);

/* The event is at `at`, or where the last one was if that is later. */
void explain_source_stamp(struct explain_source *self, dg_ns at, struct dg_tap_event *to);

#endif
