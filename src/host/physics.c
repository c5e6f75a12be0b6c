/* SPDX-License-Identifier: MIT */
/*
 * The shaft and the world. A shaft that the host moves step by step goes on between the steps with
 * the rate it was given, so that what is latched there is no staircase; nothing is rounded twice.
 */
#include "host_private.h"

#define SECOND INT64_C(1000000000)

/* floor(rate * t / 1 s) modulo 2^64 for t = `to` - `from` of any sign and length: seconds and the
 * rest of t, and of the rate, which are below 2^30. Divisions are of signed numbers, and without
 * remainders, for all need the same code; ~x stands for -1 - x, which takes the rest below 0 along.
 */
static uint64_t turned_between(int64_t rate, dg_ns from, dg_ns to)
{
    const uint64_t t = to - from;
    const uint64_t back = to < from ? UINT64_MAX : 0;
    const uint64_t s = (uint64_t)((int64_t)((t ^ back) >> 1u) / (SECOND / 2)) ^ back;
    const uint32_t ns = (uint32_t)t - (uint32_t)s * (uint32_t)SECOND;
    const uint64_t falls = 0 - ((uint64_t)rate >> 63u);
    const uint64_t high = (uint64_t)((int64_t)((uint64_t)rate ^ falls) / SECOND) ^ falls;
    const uint32_t low = (uint32_t)rate - (uint32_t)high * (uint32_t)SECOND;

    /* The last product is below 2^60; the others wrap as angles do. */
    return (uint64_t)rate * s + high * ns + (uint64_t)((int64_t)((uint64_t)low * ns) / SECOND);
}

static dg_angle angle_in(const struct host_course *course, dg_ns at)
{
    return (dg_angle)((uint64_t)course->angle + turned_between(course->rate, course->at, at));
}

dg_angle dg_host_own_angle(void *handle, dg_ns at)
{
    const struct dg_host *self = handle;

    return angle_in(at < self->course.at ? &self->before : &self->course, at);
}

int64_t dg_host_angle(const struct dg_host *self, uint64_t at)
{
    return self->world.angle(self->world.angle_ctx, at);
}

void dg_host_shaft(struct dg_host *self, uint64_t now, int64_t angle, int64_t rate)
{
    dg_host_run(self, now);
    now = self->line.now;
    if (self->course.at != now) {
        self->before = self->course;
    }
    self->course = (struct host_course){now, angle, rate};
    dg_host_run(self, now);
}

void dg_host_sit(struct dg_host *self, void *shaft, dg_angle (*angle_of)(void *shaft, dg_ns at))
{
    self->world.angle = angle_of;
    self->world.angle_ctx = shaft;
    self->world.calm = NULL;
    dg_host_run(self, self->line.now);
}

int dg_host_share(struct dg_host *self, struct dg_host *other)
{
    if (other != NULL && other->world.angle_ctx != other) {
        return DG_HOST_ERR_ARGUMENT;
    }
    dg_host_sit(self, other == NULL ? self : other, dg_host_own_angle);
    return DG_HOST_OK;
}
