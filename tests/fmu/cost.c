/* SPDX-License-Identifier: MIT */
/* What a step costs a C program: shaft, step of 1 ms, position. usage: cost LIBRARY TOKEN ANGLE
 * SPEED POSITION */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { STEPS = 200000 };

typedef void *make(const char *, const char *, const char *, bool, bool, bool, bool,
                   const uint32_t *, size_t, void *, void *, void *);
typedef int enter(void *, bool, double, double, bool, double);
typedef int begin(void *);
typedef int set(void *, const uint32_t *, size_t, const double *, size_t);
typedef int get(void *, const uint32_t *, size_t, int64_t *, size_t);
typedef int step(void *, double, double, bool, bool *, bool *, bool *, double *);

static double now(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

int main(int argc, char **argv)
{
    void *library = argc == 6 ? dlopen(argv[1], RTLD_NOW) : NULL;
    if (library == NULL) {
        return 1;
    }
    make *instantiate = (make *)dlsym(library, "fmi3InstantiateCoSimulation");
    set *set_real = (set *)dlsym(library, "fmi3SetFloat64");
    get *get_int = (get *)dlsym(library, "fmi3GetInt64");
    step *go_on = (step *)dlsym(library, "fmi3DoStep");
    enter *initialize = (enter *)dlsym(library, "fmi3EnterInitializationMode");
    begin *exit_initialization = (begin *)dlsym(library, "fmi3ExitInitializationMode");
    void *it = instantiate("it", argv[2], "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    const uint32_t shaft[2] = {(uint32_t)atol(argv[3]), (uint32_t)atol(argv[4])};
    const uint32_t position = (uint32_t)atol(argv[5]);
    if (it == NULL || initialize(it, false, 0, 0, false, 0) != 0 || exit_initialization(it) != 0) {
        return 1;
    }
    const double start = now();
    for (int i = 0; i < STEPS; i++) {
        const double values[2] = {0.314 * i, 314.0};
        bool event, end, early;
        double last;
        int64_t counts;
        if (set_real(it, shaft, 2, values, 2) != 0 ||
            go_on(it, i * 1e-3, 1e-3, 1, &event, &end, &early, &last) != 0 ||
            get_int(it, &position, 1, &counts, 1) != 0) {
            return 1;
        }
    }
    const double each = (now() - start) / STEPS;
    printf("%.0f ns a step of 1 ms, %.0f virtual seconds a second\n", each * 1e9, 1e-3 / each);
    return 0;
}
