/* SPDX-License-Identifier: MIT */
#include "drehgeber/course.h"

#include "drehgeber/angle.h"
#include "drehgeber/hal.h"

/* A place on the way: behind point `index`, at `at` of the lap that began at `lap`. */
struct place {
    size_t behind; /* points at or before it */
    dg_ns lap;
    dg_ns at;
};

/* The stretch between two points. */
struct stretch {
    dg_ns begin;
    dg_ns span;
    int32_t from;
    bool falls;
    uint32_t halves; /* half units from one to the other */
};

int dg_course_check(const struct dg_course *self)
{
    const struct dg_course_point *points = self->points;

    for (size_t i = 1; i < self->count; i++) {
        if (points[i].at < points[i - 1u].at) {
            return DG_ERR_ARGUMENT;
        }
    }
    return self->count > 0 && (!self->loop || points[self->count - 1u].at > 0) ? DG_OK
                                                                               : DG_ERR_ARGUMENT;
}

static size_t points_until(const struct dg_course *self, dg_ns at)
{
    size_t low = 0;
    size_t high = self->count;

    while (low < high) {
        const size_t middle = low + (high - low) / 2u;
        if (self->points[middle].at <= at) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

static struct place course_place_of(const struct dg_course *self, dg_ns since)
{
    struct place place = {.at = since};

    if (self->loop) {
        place.at = since % self->points[self->count - 1u].at;
        place.lap = since - place.at;
    }
    place.behind = points_until(self, place.at);
    return place;
}

static bool is_flat(const struct dg_course *self, size_t behind)
{
    return self->steps || behind == self->count ||
           self->points[behind].value == self->points[behind - 1u].value;
}

static struct stretch stretch_of(const struct dg_course *self, size_t behind)
{
    const struct dg_course_point *from = &self->points[behind - 1u];
    const struct dg_course_point *to = &self->points[behind];
    const bool falls = to->value < from->value;
    const uint32_t way = falls ? (uint32_t)from->value - (uint32_t)to->value
                               : (uint32_t)to->value - (uint32_t)from->value;

    return (struct stretch){.begin = from->at,
                            .span = to->at - from->at,
                            .from = from->value,
                            .falls = falls,
                            .halves = 2u * way};
}

/* Units from the first point to what it is at `at`. */
static uint32_t way_to(const struct stretch *self, dg_ns at)
{
    const dg_ns tick = at - at % DG_COURSE_GRID;
    const dg_ns gone = tick > self->begin ? tick - self->begin : 0;

    return ((uint32_t)dg_muldiv(gone, self->halves, self->span) + 1u) / 2u;
}

bool dg_course_at(const struct dg_course *self, dg_ns since, int32_t *value)
{
    const struct place place = course_place_of(self, since);

    if (place.behind == 0) {
        if (place.lap > 0) {
            *value = self->points[self->count - 1u].value;
        }
        return place.lap > 0;
    }
    *value = self->points[place.behind - 1u].value;
    if (!is_flat(self, place.behind)) {
        const struct stretch stretch = stretch_of(self, place.behind);
        const int32_t way = (int32_t)way_to(&stretch, place.at);
        *value += stretch.falls ? -way : way;
    }
    return true;
}

/* The first tick at which it is a unit further than at `at`; the next point may come before. */
static dg_ns next_unit(const struct stretch *self, dg_ns at)
{
    const uint64_t halves = 2u * (uint64_t)way_to(self, at) + 1u;
    const dg_ns floor = dg_muldiv(halves, self->span, self->halves);
    /* The rest of the division, modulo 2^64: it is below the divisor. */
    const bool rest = halves * self->span != floor * self->halves;
    const dg_ns moment = dg_after(self->begin, dg_after(floor, rest ? 1u : 0u));
    const dg_ns late = moment % DG_COURSE_GRID;

    return late == 0 ? moment : dg_after(moment, DG_COURSE_GRID - late);
}

dg_ns dg_course_next(const struct dg_course *self, dg_ns since)
{
    const struct place place = course_place_of(self, since);

    if (place.behind == self->count) {
        return DG_NEVER;
    }
    dg_ns next = self->points[place.behind].at;
    if (place.behind > 0 && !is_flat(self, place.behind)) {
        const struct stretch stretch = stretch_of(self, place.behind);
        next = dg_earliest(next, next_unit(&stretch, place.at));
    }
    return dg_after(place.lap, next);
}
