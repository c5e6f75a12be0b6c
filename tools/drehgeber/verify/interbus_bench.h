/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bench of the OCD encoders with INTERBUS, and the steps that have a file of their own.
 */
#ifndef DREHGEBER_VERIFY_INTERBUS_BENCH_H
#define DREHGEBER_VERIFY_INTERBUS_BENCH_H

#include <stdalign.h>

#include "drehgeber/bus_words.h"
#include "drehgeber/host_wire.h"
#include "interbus_steps.h"
#include "row_figures.h"
#include "row_memory.h"

#define INTERBUS_DEVICES_MAX 4u
#define INTERBUS_WORDS_MAX ((size_t)2 * INTERBUS_DEVICES_MAX)
#define INTERBUS_CYCLE DG_MS(1)
#define INTERBUS_MEMORY_MAX 16384u

struct interbus_slave {
    alignas(DG_HOST_ALIGN) uint8_t memory[INTERBUS_MEMORY_MAX];
    struct dg_host *encoder;
    struct dg_ib_model *model; /**< its settings */
    struct cf_memory nvm;
};

/** What the steps work with. */
struct interbus_bench {
    dg_ns now;
    int64_t from; /**< the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm;
    struct dg_world world;
    struct interbus_slave slaves[INTERBUS_DEVICES_MAX];
    struct dg_ib *ib[INTERBUS_DEVICES_MAX]; /**< the first is the one that `out` and `in` talk to */
    size_t count;
    alignas(DG_HOST_ALIGN) uint8_t of_ring[INTERBUS_MEMORY_MAX];
    struct dg_bus *ring; /**< of all devices so far; NULL: it is to be made */
    uint32_t out;
    uint32_t in;                        /**< last one seen */
    uint16_t image[INTERBUS_WORDS_MAX]; /**< IN of the ring; a failed cycle leaves it */
};

/** What the rows are run for. */
const struct cf_interbus_trial *interbus_trial(void);
/** Hexadecimal digits of which `.` may be any. */
bool interbus_matches(uint32_t word, const char *pattern, int digits);
/** counters[words[1]] of an object is words[2] */
bool interbus_check_counter(const struct cf_figure *figures, const void *object, char **words,
                            size_t n, struct cf_report *report);

/** Make the ring of all devices, unless there is one. @return false: it is refused */
bool interbus_link_ring(struct interbus_bench *b);
/** ids WORD... */
bool interbus_step_ids(void *ctx, char **words, size_t n, struct cf_report *report);
/** data RESULT OUT... : IN... */
bool interbus_step_data(void *ctx, char **words, size_t n, struct cf_report *report);
/** break N|none */
bool interbus_step_break(void *ctx, char **words, size_t n, struct cf_report *report);
/** corrupt N */
bool interbus_step_corrupt(void *ctx, char **words, size_t n, struct cf_report *report);
/** module N: the first device with a module error; -1: none */
bool interbus_step_module(void *ctx, char **words, size_t n, struct cf_report *report);
/** cycletime BAUD SOFTWARE_US NS */
bool interbus_step_cycletime(void *ctx, char **words, size_t n, struct cf_report *report);
/** bits BYTES DEVICES BITS */
bool interbus_step_bits(void *ctx, char **words, size_t n, struct cf_report *report);
/** ringcount COUNTER N */
bool interbus_step_ringcount(void *ctx, char **words, size_t n, struct cf_report *report);
/** ringsize N ok|refused */
bool interbus_step_ringsize(void *ctx, char **words, size_t n, struct cf_report *report);
/** blink ON OFF: how long BA is lit and dark in a second of ID cycles, to a cycle of 20 ms */
bool interbus_step_blink(void *ctx, char **words, size_t n, struct cf_report *report);

#endif
