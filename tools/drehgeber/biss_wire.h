/* SPDX-License-Identifier: MIT */
/*
 * A BiSS encoder on a simulated wire: a master that clocks every edge, virtual time, and a record
 * of the levels.
 */
#ifndef DREHGEBER_TOOL_BISS_WIRE_H
#define DREHGEBER_TOOL_BISS_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "drehgeber/biss.h"

/* 1 MHz. */
#define BISS_WIRE_HALF_NS 500u

/* What an access can end in; what is not negative counts registers. */
enum biss_wire_failure {
    BISS_WIRE_SILENT = -1,   /* the encoder did not answer */
    BISS_WIRE_REFUSED = -2,  /* register not implemented, protected, or not ready */
    BISS_WIRE_TOO_BUSY = -3, /* longer than 20 ms */
    BISS_WIRE_DAMAGED = -4,  /* a check sum is wrong */
};

/* The wire. */
struct biss_wire {
    struct dg_biss *device;
    dg_ns now;
    uint8_t data_bits; /* behind CDS: position, nERR, nWARN, LC, CRC */
    uint64_t bits;     /* of the last frame, right-aligned */
    FILE *trace;       /* NULL: none */
    bool ma;           /* as recorded */
    bool slo;
};

/* A position as it came over the wire. */
struct biss_wire_position {
    uint64_t position; /* MT:ST */
    uint8_t life;
    bool n_err;
    bool n_warn;
    bool crc_ok;
};

/* Put `device`, which has its power, on a wire at `now`. `trace` gets a VCD file. */
void biss_wire_init(struct biss_wire *self, struct dg_biss *device, dg_ns now, FILE *trace);

/* Nothing happens until `now`. */
void biss_wire_pause(struct biss_wire *self, dg_ns now);

/* A frame with CDM = 0, and what was in it. */
struct biss_wire_position biss_wire_read_position(struct biss_wire *self);

/* Read, or write, `n` registers in one control frame. @return how many, or enum biss_wire_failure
 */
int biss_wire_read(struct biss_wire *self, uint8_t address, uint8_t *bytes, size_t n);
int biss_wire_write(struct biss_wire *self, uint8_t address, const uint8_t *bytes, size_t n);

#endif
