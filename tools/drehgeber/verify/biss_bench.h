/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bench of the BiSS steps: slaves on a line, their shaft and world, and the master.
 */
#ifndef DREHGEBER_VERIFY_BISS_BENCH_H
#define DREHGEBER_VERIFY_BISS_BENCH_H

#include <stdbool.h>
#include <stddef.h>

#include "biss_steps.h"
#include "row_memory.h"

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
    struct cf_biss_frames frames; /* those of the last step that clocked some */
    struct cf_biss_access access; /* the last one */
    unsigned frames_before;       /* that step: of the master's */
    bool asked;                   /* the row has looked at the wire */
    bool turned;                  /* the row has said where the shaft is */
};

/** What a model has answered, and whether it is what the row expects. */
struct biss_said {
    const void *what;
    size_t n;
    bool matched;
};

/** Empty: no slave yet, a healthy world, the shaft at rest at angle 0. */
void biss_bench_begin(struct biss_bench *b);

/** Angle of the shaft; dg_world.angle with the bench as context. */
dg_angle biss_bench_angle(void *ctx, dg_ns now);

/** Let time pass without an edge. */
void biss_bench_wait(struct biss_bench *b, dg_ns wait);

/** What the rows are run for. */
const struct cf_biss_trial *biss_trial(void);

/** Whether somebody is asked the same as the model. */
bool biss_has_beside(void);

/** What only these bits of enum cf_need allow. @return false after cf_fail(), likewise the next ones
 */
bool biss_need(unsigned needs, struct cf_report *report);

/** Let time pass, for whoever is asked the same, too. */
bool biss_wait_beside(struct biss_bench *b, dg_ns wait, struct cf_report *report);

/** Switch the supply of whoever is asked the same. */
bool biss_power_beside(bool on, struct cf_report *report);

/** Ask whoever is asked the same; then the model is asked. */
bool biss_ask(struct biss_bench *b, uint16_t kind, const void *what, size_t n,
              struct cf_report *report);

/** Judge what was answered to that. */
bool biss_judge(const struct biss_bench *b, uint16_t kind, const struct biss_said *said,
                struct cf_report *report);

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
