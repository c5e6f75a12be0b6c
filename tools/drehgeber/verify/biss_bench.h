/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bench of the BiSS steps: slaves on a line, their shaft and world, and the master.
 */
#ifndef DREHGEBER_VERIFY_BISS_BENCH_H
#define DREHGEBER_VERIFY_BISS_BENCH_H

#include <stdbool.h>
#include <stddef.h>

#include "biss_master.h"
#include "drehgeber/biss.h"
#include "row_memory.h"
#include "rows.h"

/** A slave and its EEPROM. */
struct biss_slave {
    struct dg_biss_model model;
    struct cf_memory nvm;
    struct dg_biss device;
};

/** Everything; plain data that biss_bench_begin() sets up. */
struct biss_bench {
    int64_t from; /* the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm;
    struct dg_world world;
    struct biss_slave slaves[BISS_SLAVES_MAX]; /* 0 is next to the master */
    struct dg_biss_chain chain;                /* count 0: `given` has not been */
    dg_ns deadline;
    struct biss_master master;
    struct biss_frame frame;   /* the last one of `scd` or `frame` */
    struct biss_access access; /* the last one */
};

/** Empty: no slave yet, a healthy world, the shaft at rest at angle 0. */
void biss_bench_begin(struct biss_bench *b);

/** Angle of the shaft; dg_world.angle with the bench as context. */
dg_angle biss_bench_angle(void *ctx, dg_ns now);

/** Let time pass without an edge. */
void biss_bench_wait(struct biss_bench *b, dg_ns wait);

/** "5ms", "300us", "100ns"; 0 when it is none of them. */
dg_ns biss_bench_span(const char *word);

/** Steps that set something up; see biss.rows. @return false after cf_fail() */
bool biss_bench_given(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_behind(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_power(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_pos(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_rpm(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_world(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_after(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_damage(void *ctx, char **words, size_t n, struct cf_report *report);
bool biss_bench_master(void *ctx, char **words, size_t n, struct cf_report *report);

#endif
