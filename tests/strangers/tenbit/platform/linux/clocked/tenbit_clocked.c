/* SPDX-License-Identifier: MIT */
/* The master of a simulated wire: a word at a time. There is nothing in it that could be wrong. */
#include "tenbit_clocked.h"

#include <stdio.h>

#include "clocked_wire.h"
#include "drehgeber/tenbit.h"
#include "trace_format.h"

/* A master waits a little longer than the monoflop time. */
#define PAUSE_NS DG_US(1)

/* A line, and what was read last. */
struct tenbit_line {
    struct lx_clocked base;
    uint32_t word;
};

static int check(const struct lx_bus_setup *setup, const struct lx_station *station,
                 enum lx_clocked_master master, struct lx_error *error)
{
    const char *name = station->plan->model->name;
    (void)setup;
    return master == LX_CLOCKED_HERE ? 0
                                     : lx_refuse(error, "sim is right",
                                                 "%s has no time for a master in user space", name);
}

static uint32_t rises(const struct lx_clocked *base)
{
    (void)base;
    return DG_TENBIT_BITS;
}

static void read_frame(struct lx_clocked *base, struct lx_clocked_wire *wire)
{
    uint32_t word = 0;
    wire->delay = wire->compensates ? wire->way_ns : 0;
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        word = word << 1 | lx_clocked_wire_bit(wire);
    }
    ((struct tenbit_line *)base)->word = word;
    lx_clocked_wire_pause(wire, wire->now + DG_TENBIT_MONOFLOP + wire->way_ns + PAUSE_NS);
}

static void skip(struct lx_clocked *base, uint64_t n)
{
    ((struct dg_tenbit *)lx_clocked_device(base, 0))->frames += (uint32_t)n;
}

static enum lx_clocked_verdict judge(const struct lx_clocked *base, size_t encoder)
{
    (void)base;
    (void)encoder;
    return LX_CLOCKED_GOOD;
}

static void word(const struct lx_clocked *base, size_t encoder, struct lx_clocked_word *out)
{
    const uint32_t bits = ((const struct tenbit_line *)base)->word;
    (void)encoder;
    *out = (struct lx_clocked_word){.bits = bits, .count = DG_TENBIT_BITS, .singleturn = bits};
}

static void print(const struct lx_clocked *base, size_t encoder, char *text, size_t size)
{
    (void)encoder;
    (void)snprintf(text, size, "word %u", (unsigned)((const struct tenbit_line *)base)->word);
}

static void note(const struct lx_clocked *base, const struct lx_clocked_wire *wire, size_t encoder,
                 char *text, size_t size)
{
    (void)wire;
    print(base, encoder, text, size);
}

static const struct lx_clocked_protocol protocol = {
    .clock = "CLOCK",
    .data = "DATA",
    .size = sizeof(struct tenbit_line),
    .check = check,
    .rises = rises,
    .read = read_frame,
    .skip = skip,
    .judge = judge,
    .word = word,
    .note = note,
    .print = print,
};

/* --- what a plan knows of it --- */

static const struct lx_trace_format vcd = LX_TRACE_CLOCKED("tenbit", "CLOCK", "DATA");

const struct lx_stack lx_tenbit_stack = {
    .core = &dg_tenbit_stack,
    .handle = &dg_tenbit_wire,
    .trace = &(const struct lx_trace_kind){"ten bits", {&vcd}, false},
    .clocked = &protocol,
    .wire = "sim",
};
