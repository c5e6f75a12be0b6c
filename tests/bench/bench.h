/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What every bench has in common: it counts instructions, or takes the time, of things that are
 * done again and again in virtual time. A program is a table of them and one call of bench_main().
 *
 *   bench_NAME            `FIGURE ns`: the fastest of many batches, those of all figures in turn,
 *                         in processor time of this process
 *   bench_NAME --count    each once in bench_counted(), after some to warm up, and `FIGURE PARTS`
 * for each in this order; then `FIGURE bytes N`. See instructions.sh
 */
#ifndef TESTS_BENCH_BENCH_H
#define TESTS_BENCH_BENCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Something that is done again and again, each time as it was the time before. */
struct bench {
    const char *name;              /**< of the figure, as in `limits` */
    void (*run)(const void *what); /**< once */
    const void *what;
    unsigned answers; /**< that it brings, all of them right */
    unsigned parts;   /**< the figure is one of so many alike: edges of a frame; 0 as 1 */
};

/** What something takes in RAM. */
struct bench_bytes {
    const char *name;
    size_t bytes;
};

/** A program. */
struct bench_set {
    const struct bench *benches;
    size_t count;
    const struct bench_bytes *bytes;
    size_t bytes_count;
    bool (*start)(void);       /**< make what the benches need. @return whether it runs */
    uint64_t (*answers)(void); /**< right ones so far */
};

/** Count or measure. @return what main() returns: 1 when an answer is missing or wrong */
int bench_main(int argc, char **argv, const struct bench_set *set);

#endif
