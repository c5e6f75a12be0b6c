/* SPDX-License-Identifier: MIT */
/*
 * What the library makes waits for all others to know of it, without limit for one who goes
 * meanwhile, and nothing interrupts it. So it is made on a thread of its own:
 *
 *   wait() --> thread: make() ... returns --> wait() joins it and goes on
 *          --> nobody answers, or a signal to end: the thread is left behind, as is all that it has
 */
#define _GNU_SOURCE
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

#include "ending.h"
#include "silkit_parts.h"

#define WAIT_MS 10000u
#define LOOK_MS 20u

struct waiting {
    struct lx_silkit_call call;
    struct lx_error error;
    int result;
};

static atomic_bool left_behind;

bool lx_silkit_is_left_behind(void)
{
    return atomic_load(&left_behind);
}

static void *make(void *ctx)
{
    struct waiting *self = ctx;
    self->result = self->call.make(&self->call, &self->error);
    return NULL;
}

/* A little while, or until the thread is done, and joined. */
static bool join_briefly(pthread_t thread)
{
    struct timespec end;
    (void)clock_gettime(CLOCK_REALTIME, &end);
    const int64_t ns = end.tv_nsec + (int64_t)LOOK_MS * 1000000;
    end.tv_sec += (time_t)(ns / 1000000000);
    end.tv_nsec = (long)(ns % 1000000000);
    return pthread_timedjoin_np(thread, NULL, &end) == 0;
}

static int leave_behind(struct waiting *self, pthread_t thread, struct lx_error *error)
{
    atomic_store(&left_behind, true);
    (void)pthread_detach(thread);
    return lx_ending_asked()
               ? lx_fail(error, "SIL Kit: %s: stopped before it was complete", self->call.name)
               : lx_refuse(error, "expected a running registry and running participants",
                           "SIL Kit: %s: no answer for %u s", self->call.name, WAIT_MS / 1000u);
}

static int finish_call(struct waiting *self, struct lx_silkit_call *call, struct lx_error *error)
{
    const int result = self->result;
    *call = self->call;
    if (result != 0) {
        *error = self->error;
    }
    free(self);
    return result;
}

static int start_call(struct waiting *self, pthread_t *thread)
{
    sigset_t before;
    lx_silkit_mask(&before);
    const int result = pthread_create(thread, NULL, make, self);
    lx_silkit_unmask(&before);
    return result;
}

int lx_silkit_wait(struct lx_silkit_call *call, struct lx_error *error)
{
    pthread_t thread;
    struct waiting *self = lx_allocate(sizeof *self, "a simulation", error);
    if (self == NULL) {
        return -1;
    }
    self->call = *call;
    if (start_call(self, &thread) != 0) {
        free(self);
        return lx_fail(error, "no thread for a simulation");
    }
    bool done = join_briefly(thread);
    for (unsigned ms = 0; !done && ms < WAIT_MS && !lx_ending_asked(); ms += LOOK_MS) {
        done = join_briefly(thread);
    }
    return done ? finish_call(self, call, error) : leave_behind(self, thread, error);
}
