/* SPDX-License-Identifier: MIT */
/*
 * INTERBUS: a row for each cycle with a change. The first cycle says how many words there are.
 */
#include <inttypes.h>
#include <string.h>

#include "trace_format.h"

#define NS_PER_S 1000000000u
/* All that a ring can have, either way. */
#define WORDS_MAX 512u
/* A ring has one word at least. */
#define BEGIN "time_s,in_0,"

/* The row written last. */
struct csv {
    bool begun;
    bool valid;
    uint16_t count;
    uint16_t in[WORDS_MAX];
    uint16_t out[WORDS_MAX];
};

static void put_header(const struct csv *csv, FILE *file)
{
    (void)fputs("time_s", file);
    for (uint16_t i = 0; i < csv->count; i++) {
        (void)fprintf(file, ",in_%u", i);
    }
    for (uint16_t i = 0; i < csv->count; i++) {
        (void)fprintf(file, ",out_%u", i);
    }
    (void)fputs(",valid\n", file);
}

static void put_words(const struct csv *csv, const uint16_t *words, FILE *file)
{
    for (uint16_t i = 0; i < csv->count; i++) {
        (void)fprintf(file, ",%04X", words[i]);
    }
}

static void put_csv_row(const struct csv *csv, dg_ns at, FILE *file)
{
    (void)fprintf(file, "%" PRIu64 ".%09" PRIu64, at / NS_PER_S, at % NS_PER_S);
    put_words(csv, csv->in, file);
    put_words(csv, csv->out, file);
    (void)fprintf(file, ",%d\n", csv->valid);
}

/* @return whether it differs from what was there */
static bool take_changed_words(uint16_t *to, const uint16_t *words, size_t n)
{
    const bool differs = memcmp(to, words, n * sizeof *to) != 0;
    memcpy(to, words, n * sizeof *to);
    return differs;
}

/* Rows keep the number of columns: words beyond are left out, missing ones stay as they were. */
static void csv_event(struct lx_trace *self, const struct dg_tap_event *event)
{
    struct csv *csv = self->own;
    if (event->kind != DG_TAP_WORDS || event->words.count == 0) {
        return;
    }
    const uint16_t count = event->words.count < WORDS_MAX ? event->words.count : WORDS_MAX;
    bool changed = !csv->begun;
    if (!csv->begun) {
        csv->begun = true;
        csv->count = count;
        put_header(csv, self->file);
    }
    const size_t n = count < csv->count ? count : csv->count;
    changed |= take_changed_words(csv->in, event->words.in, n);
    changed |= take_changed_words(csv->out, event->words.out, n);
    changed |= csv->valid != event->words.valid;
    csv->valid = event->words.valid;
    if (changed) {
        put_csv_row(csv, dg_elapsed(event->at, self->opened), self->file);
    }
}

const struct lx_trace_format lx_trace_csv = {
    .ending = ".csv",
    .mark = {0, sizeof BEGIN - 1u, BEGIN},
    .size = sizeof(struct csv),
    .event = csv_event,
};
