/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#define WARM_UP 3u
#define ROUNDS 40u
#define BATCH_NS 1e6
#define BENCHES_MAX 32u

/* What callgrind counts; called by a pointer it does not see through, so that it stays a function.
 */
void bench_counted(const struct bench *bench);
void bench_counted(const struct bench *bench)
{
    bench->run(bench->what);
}
static void (*volatile once)(const struct bench *bench) = bench_counted;

static unsigned parts_of(const struct bench *bench)
{
    return bench->parts == 0 ? 1 : bench->parts;
}

static double now_ns(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

/* `runs` of it, all answered. @return nanoseconds, or -1 */
static double batch(const struct bench_set *set, const struct bench *bench, uint64_t runs)
{
    const uint64_t before = set->answers();
    const double begin = now_ns();

    for (uint64_t i = 0; i < runs; i++) {
        bench->run(bench->what);
    }
    const double elapsed = now_ns() - begin;
    const uint64_t answers = set->answers() - before;
    if (answers != runs * bench->answers) {
        (void)fprintf(stderr, "%s: %" PRIu64 " times, %" PRIu64 " right answers\n", bench->name,
                      runs, answers);
        return -1;
    }
    return elapsed;
}

/* As many runs as take about BATCH_NS; 0: not answered. */
static uint64_t batch_size(const struct bench_set *set, const struct bench *bench)
{
    uint64_t runs = 1;
    double elapsed = batch(set, bench, runs);

    while (elapsed >= 0 && elapsed < BATCH_NS) {
        runs *= 2;
        elapsed = batch(set, bench, runs);
    }
    return elapsed < 0 ? 0 : runs;
}

static int measure(const struct bench_set *set)
{
    uint64_t runs[BENCHES_MAX];
    double best[BENCHES_MAX] = {0};

    for (size_t i = 0; i < set->count; i++) {
        runs[i] = batch_size(set, &set->benches[i]);
        best[i] = 1e18;
        if (runs[i] == 0) {
            return 1;
        }
    }
    /* In turn: what disturbs for a while disturbs all, and no figure has seen nothing else. */
    for (size_t i = 0; i < ROUNDS * set->count; i++) {
        const size_t at = i % set->count;
        const double elapsed = batch(set, &set->benches[at], runs[at]);
        if (elapsed < 0) {
            return 1;
        }
        const double each = elapsed / (double)runs[at] / parts_of(&set->benches[at]);
        best[at] = each < best[at] ? each : best[at];
    }
    for (size_t i = 0; i < set->count; i++) {
        (void)printf("%-36s %12.1f\n", set->benches[i].name, best[i]);
    }
    return 0;
}

static int count(const struct bench_set *set)
{
    for (size_t i = 0; i < set->count; i++) {
        const struct bench *bench = &set->benches[i];
        const uint64_t expected = set->answers() + (uint64_t)bench->answers * (WARM_UP + 1u);
        if (batch(set, bench, WARM_UP) < 0) {
            return 1;
        }
        once(bench);
        if (set->answers() != expected) {
            (void)fprintf(stderr, "%s: not answered\n", bench->name);
            return 1;
        }
        (void)printf("%s %u\n", bench->name, parts_of(bench));
    }
    for (size_t i = 0; i < set->bytes_count; i++) {
        (void)printf("%s bytes %zu\n", set->bytes[i].name, set->bytes[i].bytes);
    }
    return 0;
}

int bench_main(int argc, char **argv, const struct bench_set *set)
{
    const bool counting = argc == 2 && strcmp(argv[1], "--count") == 0;

    if ((argc != 1 && !counting) || set->count > BENCHES_MAX) {
        (void)fprintf(stderr, "usage: %s [--count]\n", argv[0]);
        return 2;
    }
    if (!set->start()) {
        (void)fprintf(stderr, "%s: it does not start\n", argv[0]);
        return 1;
    }
    return counting ? count(set) : measure(set);
}
