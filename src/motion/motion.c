/* SPDX-License-Identifier: MIT */
#include "drehgeber/motion.h"

#include "drehgeber/hal.h"
#include "motion_private.h"

/*
 * A shaft at m * 0.001 rpm travels m * 2^32 / 6e13 units of 2^-32 turn in a nanosecond, which
 * is m * 2^18 / TRAVEL_NS in lowest terms: a whole number of units in every TRAVEL_NS.
 */
#define TRAVEL_NS 3662109375u
#define TRAVEL_UNITS_PER_MRPM ((uint64_t)1 << 18)

/** Bits of a fraction of a nanosecond. */
#define FRACTION_BITS 20

#define AMPLITUDE_MAX ((dg_angle)1 << 40)
#define SINE_ONE ((uint64_t)1 << 30)

/** The time at full speed that a motion's travel is worth. */
struct travel_time {
    dg_ns whole;
    uint64_t fraction; /**< in 2^-20 ns, below 2^20 */
};

/** Where the motion is after `time` at its full speed; floor of the exact value. */
static dg_angle at_full_speed(const struct dg_motion *self, struct travel_time time)
{
    bool backwards = self->mrpm < 0;
    uint64_t mrpm = motion_exact_magnitude(self->mrpm);
    uint64_t whole = time.whole / TRAVEL_NS * mrpm * TRAVEL_UNITS_PER_MRPM;
    uint64_t rest = (time.whole % TRAVEL_NS << FRACTION_BITS) + time.fraction;
    uint64_t part = motion_exact_muldiv(
        rest, mrpm, ((uint64_t)TRAVEL_NS << FRACTION_BITS) / TRAVEL_UNITS_PER_MRPM, backwards);

    return motion_exact_moved(self->from, backwards, whole + part);
}

/** What `time` from or to standstill is worth at full speed: time^2 / (2 accel), in 2^-20 ns. */
static uint64_t slope_q20(dg_ns time, dg_ns accel)
{
    return dg_muldiv(time, time << FRACTION_BITS, 2 * accel);
}

static struct travel_time travel_time(dg_ns whole, uint64_t fraction)
{
    return (struct travel_time){
        .whole = whole + (fraction >> FRACTION_BITS),
        .fraction = fraction & (((uint64_t)1 << FRACTION_BITS) - 1),
    };
}

/*
 *  speed    ______________
 *         /|              |\      Each slope travels as far as half its length at full speed, so
 *        / |              | \     the whole is worth accel + hold.
 *      _/  |              |  \_
 *       accel     hold    accel
 */
static struct travel_time ramp_time(const struct dg_motion *self, dg_ns t)
{
    dg_ns since_top = dg_elapsed(t, self->accel);
    dg_ns since_end = dg_elapsed(since_top, self->hold);

    if (t < self->accel) {
        return travel_time(0, slope_q20(t, self->accel));
    }
    if (since_top <= self->hold) {
        return travel_time(since_top, slope_q20(self->accel, self->accel));
    }
    if (since_end < self->accel) {
        dg_ns left = self->accel - since_end;

        /* The slope back is the slope up, mirrored: what is still to come is missing. */
        return travel_time(self->hold,
                           (self->accel << FRACTION_BITS) - slope_q20(left, self->accel));
    }
    return travel_time(self->accel + self->hold, 0);
}

static dg_angle sine_at(const struct dg_motion *self, dg_ns t)
{
    /* To the nearest phase: half a unit of phase is 2^-30.3 of the amplitude. */
    uint64_t half_units = dg_muldiv(t % self->period, (uint64_t)1 << 33, self->period);
    int64_t sine = dg_sin_q30((uint32_t)((half_units + 1) >> 1));
    bool backwards = (sine < 0) != (self->amplitude < 0);
    uint64_t amplitude = motion_exact_magnitude(self->amplitude);

    return motion_exact_moved(self->from, backwards,
                              dg_muldiv(amplitude, (uint64_t)(sine < 0 ? -sine : sine), SINE_ONE));
}

/** How many of the points are at or before `t`. */
static size_t points_until(const struct dg_motion *self, dg_ns t)
{
    size_t low = 0;
    size_t high = self->point_count;

    while (low < high) {
        size_t middle = low + (high - low) / 2;

        if (self->points[middle].at <= t) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

static dg_angle replay_at(const struct dg_motion *self, dg_ns t)
{
    size_t passed = points_until(self, t);

    if (passed == 0) {
        return self->points[0].angle;
    }
    if (passed == self->point_count) {
        return self->points[passed - 1].angle;
    }

    const struct dg_motion_point *a = &self->points[passed - 1];
    const struct dg_motion_point *b = &self->points[passed];
    bool backwards = b->angle < a->angle;
    uint64_t line = backwards ? (uint64_t)a->angle - (uint64_t)b->angle
                              : (uint64_t)b->angle - (uint64_t)a->angle;

    return motion_exact_moved(a->angle, backwards,
                              motion_exact_muldiv(line, t - a->at, b->at - a->at, backwards));
}

dg_angle dg_motion_angle(void *ctx, dg_ns now)
{
    const struct dg_motion *self = ctx;
    dg_ns t = dg_elapsed(now, self->start);

    switch (self->kind) {
    case DG_MOTION_SPEED:
        return at_full_speed(self, travel_time(t, 0));
    case DG_MOTION_RAMP:
        return at_full_speed(self, ramp_time(self, t));
    case DG_MOTION_SINE:
        return sine_at(self, t);
    case DG_MOTION_REPLAY:
        return replay_at(self, t);
    case DG_MOTION_STANDSTILL:
    case DG_MOTION_KIND_COUNT:
        break;
    }
    return self->from;
}

static bool speed_in_range(const struct dg_motion *self)
{
    return self->mrpm >= -DG_MOTION_SPEED_MAX_MRPM && self->mrpm <= DG_MOTION_SPEED_MAX_MRPM;
}

static bool span_in_range(dg_ns span, dg_ns max)
{
    return span >= 1 && span <= max;
}

static bool points_in_range(const struct dg_motion *self)
{
    if (self->points == NULL || self->point_count == 0) {
        return false;
    }
    for (size_t i = 1; i < self->point_count; i++) {
        if (self->points[i].at <= self->points[i - 1].at) {
            return false;
        }
    }
    return true;
}

static bool in_range(const struct dg_motion *self)
{
    switch (self->kind) {
    case DG_MOTION_STANDSTILL:
        return true;
    case DG_MOTION_SPEED:
        return speed_in_range(self);
    case DG_MOTION_RAMP:
        return speed_in_range(self) && span_in_range(self->accel, DG_MOTION_RAMP_MAX);
    case DG_MOTION_SINE:
        return self->amplitude >= -AMPLITUDE_MAX && self->amplitude <= AMPLITUDE_MAX &&
               span_in_range(self->period, DG_MOTION_PERIOD_MAX);
    case DG_MOTION_REPLAY:
        return points_in_range(self);
    case DG_MOTION_KIND_COUNT:
        break;
    }
    return false;
}

int dg_motion_set(struct dg_motion *self, const struct dg_motion *wanted)
{
    if (!in_range(wanted)) {
        return DG_ERR_ARGUMENT;
    }
    *self = *wanted;
    return DG_OK;
}
