/* SPDX-License-Identifier: MIT */
/* Not a master but a referee: whether the machine itself keeps time. It comes before all else and
   does nothing but look at the clock, so what holds it up is not the encoders' doing. */
#define _GNU_SOURCE
#include "masters.h"

#include <sched.h>

#define TICK NS_PER_MS
#define STALL (2 * NS_PER_MS)
#define PRIORITY 20

/* "clock AT LATE" in ns for each stall; where the priority is not allowed, it sees more of them. */
void run_clock(struct master *self)
{
    const struct sched_param first = {.sched_priority = PRIORITY};
    (void)sched_setscheduler(0, SCHED_FIFO, &first);
    int64_t at = now_ns();
    while (goes_on(self)) {
        at += TICK;
        sleep_until(at);
        const int64_t late = now_ns() - at;
        took(self, at);
        self->exchanges++;
        if (late > STALL) {
            say("clock", "%lld %lld", (long long)at, (long long)late);
            at = now_ns();
        }
    }
}
