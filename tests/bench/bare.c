/* SPDX-License-Identifier: MIT */
/* bench_main() where there is neither a clock nor a console: cycles.py emulates the machine, and
 * counts what bench_counted() takes. */
#include "bench.h"

#define WARM_UP 3u

void bench_counted(const struct bench *bench);
void bench_counted(const struct bench *bench)
{
    bench->run(bench->what);
}
static void (*volatile once)(const struct bench *bench) = bench_counted;

int bench_main(int argc, char **argv, const struct bench_set *set)
{
    (void)argc;
    (void)argv;
    if (!set->start()) {
        return 1;
    }
    for (size_t i = 0; i < set->count; i++) {
        const struct bench *bench = &set->benches[i];
        const uint64_t expected = set->answers() + (uint64_t)bench->answers * (WARM_UP + 1u);
        for (unsigned n = 0; n < WARM_UP; n++) {
            bench->run(bench->what);
        }
        once(bench);
        if (set->answers() != expected) {
            return 1;
        }
    }
    return 0;
}
