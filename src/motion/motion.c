/* SPDX-License-Identifier: MIT */
#include "drehgeber/motion.h"

#include "drehgeber/hal.h"
#include "motion_private.h"

/** Bits of a fraction of a nanosecond. */
#define FRACTION_BITS 20

/** Limbs of 16 bits. */
#define TIME_LIMBS 6u
#define RATE_LIMBS 8u

#define AMPLITUDE_MAX ((dg_angle)1 << 40)
#define SINE_BITS 30
#define HALF_UNIT_BITS 33

/** The time at full speed that a motion's travel is worth, in 2^-20 ns: below 2^85. */
struct travel_time {
    uint16_t limb[TIME_LIMBS];
};

static void put_limbs(uint16_t *limb, uint64_t value)
{
    limb[0] = (uint16_t)value;
    limb[1] = (uint16_t)(value >> 16);
    limb[2] = (uint16_t)(value >> 32);
    limb[3] = (uint16_t)(value >> 48);
}

static uint64_t limbs_at(const uint16_t *limb)
{
    return (uint64_t)((uint32_t)limb[3] << 16 | limb[2]) << 32 |
           ((uint32_t)limb[1] << 16 | limb[0]);
}

/*
 * A shaft at m * 0.001 rpm travels m * 2^32 / 6e13 units of 2^-32 turn in a nanosecond, which in
 * 2^-20 ns is m / TRAVEL, TRAVEL = 14 648 437 500. rate = ceil(ceil(2^160 / TRAVEL) * m / 2^32) is
 * above 2^128 * m / TRAVEL by less than 2, as m is below 2^32.
 */
static void make_rate(struct dg_motion_ready *self, int32_t mrpm)
{
    static const uint16_t per_mrpm[RATE_LIMBS] = {0x253E, 0x5790, 0xE1FB, 0xB821,
                                                  0xAF5B, 0xC3E6, 0x5BC0, 0x4B0F};
    const uint64_t magnitude = dg_motion_exact_magnitude(mrpm);
    uint16_t sum[2u + RATE_LIMBS] = {UINT16_MAX, UINT16_MAX};

    sum[RATE_LIMBS] = dg_motion_limbs_add(&sum[0], (uint16_t)magnitude, per_mrpm, RATE_LIMBS);
    sum[RATE_LIMBS + 1u] =
        dg_motion_limbs_add(&sum[1], (uint16_t)(magnitude >> 16), per_mrpm, RATE_LIMBS);
    for (unsigned i = 0; i < RATE_LIMBS; i++) {
        self->rate[i] = sum[i + 2u];
    }
    self->mrpm = mrpm;
}

/** The motion's own, or, when that is of another time, `made`. @param of accel or period */
static const struct dg_reciprocal *reciprocal(const struct dg_motion *self, dg_ns of,
                                              struct dg_reciprocal *made)
{
    if (self->ready.of == of) {
        return &self->ready.by;
    }
    *made = dg_reciprocal_of(of);
    return made;
}

/** Likewise for the speed. */
static const uint16_t *rate_of(const struct dg_motion *self, struct dg_motion_ready *made)
{
    if (self->ready.mrpm == self->mrpm) {
        return self->ready.rate;
    }
    make_rate(made, self->mrpm);
    return made->rate;
}

/*
 * Where the motion is after `time` at its full speed; floor of the exact value.
 *
 * The exact distance is a whole number of 1 / TRAVEL, which is more than 2^-34 unit. So it may come
 * out too large by less than that and its floor is right. time * rate / 2^128 is too large by less
 * than 2^86 * 2^-128; products below limb 4 are left out, which makes it smaller by less than
 * 2^83 * 2^-128, and 2^84 are added for them. Backwards the distance is rounded up: 1 - 2^-34 more
 * is too little for a whole number of units, and enough for every other one, as 1 / TRAVEL is above
 * 2^-34 + 2^-37. It is modulo 2^64.
 */
static dg_angle at_full_speed(const struct dg_motion *self, const struct travel_time *time)
{
    const bool backwards = self->mrpm < 0;
    const uint16_t *limb = time->limb;
    struct dg_motion_ready made;
    const uint16_t *rate = rate_of(self, &made);
    uint16_t sum[12];

    put_limbs(&sum[4], backwards ? UINT64_C(0xFFFFFFFFC0000000) : 0x0000000000100000);
    put_limbs(&sum[8], 0);
    for (unsigned i = 0; i < 4u; i++) {
        if (limb[i] != 0) {
            sum[8u + i] = dg_motion_limbs_add(&sum[4], limb[i], &rate[4u - i], 4u + i);
        }
    }
    if ((limb[4] | limb[5]) != 0) { /* from five hours at full speed on */
        (void)dg_motion_limbs_add(&sum[4], limb[4], rate, 8);
        (void)dg_motion_limbs_add(&sum[5], limb[5], rate, 7);
    }
    return dg_motion_exact_moved(self->from, backwards, limbs_at(&sum[8]));
}

static struct travel_time travel_time(dg_ns whole, uint64_t fraction)
{
    struct travel_time time;
    uint64_t low = (whole << FRACTION_BITS) + fraction;
    uint32_t high = (uint32_t)(whole >> (64 - FRACTION_BITS)) + (low < fraction ? 1u : 0u);

    put_limbs(time.limb, low);
    time.limb[4] = (uint16_t)high;
    time.limb[5] = (uint16_t)(high >> 16);
    return time;
}

/** What `time` from or to standstill is worth at full speed: time^2 / (2 accel), in 2^-20 ns.
 * @param time at most accel, which is below 2^42 */
static uint64_t slope_q20(const struct dg_motion *self, dg_ns time)
{
    struct dg_reciprocal made;
    const struct dg_reciprocal *by = reciprocal(self, self->accel, &made);
    uint64_t rest;

    return dg_divide_by(dg_wide_product(time << by->shift, time << (FRACTION_BITS - 1)), by, &rest);
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
        return travel_time(0, slope_q20(self, t));
    }
    if (since_top <= self->hold) {
        return travel_time(since_top, self->accel << (FRACTION_BITS - 1));
    }
    if (since_end < self->accel) {
        dg_ns left = self->accel - since_end;

        /* The slope back is the slope up, mirrored: what is still to come is missing. */
        return travel_time(self->hold, (self->accel << FRACTION_BITS) - slope_q20(self, left));
    }
    return travel_time(self->accel + self->hold, 0);
}

/** Half units of phase: floor(rest * 2^33 / period) of what is left of t behind whole periods. */
static uint64_t half_units(const struct dg_motion *self, dg_ns t)
{
    struct dg_reciprocal made;
    const struct dg_reciprocal *by = reciprocal(self, self->period, &made);
    struct dg_wide shifted = {.high = t >> 1 >> (63 - by->shift), .low = t << by->shift};
    uint64_t rest;

    (void)dg_divide_by(shifted, by, &rest);
    shifted.high = rest >> (64 - HALF_UNIT_BITS);
    shifted.low = rest << HALF_UNIT_BITS;
    return dg_divide_by(shifted, by, &rest);
}

static dg_angle sine_at(const struct dg_motion *self, dg_ns t)
{
    /* To the nearest phase: half a unit of phase is 2^-30.3 of the amplitude. */
    int32_t sine = dg_sin_q30((uint32_t)((half_units(self, t) + 1) >> 1));
    bool backwards = (sine < 0) != (self->amplitude < 0);
    uint64_t amplitude = dg_motion_exact_magnitude(self->amplitude);
    uint32_t factor = (uint32_t)(sine < 0 ? -sine : sine);

    /* The upper half of the product is a whole number of its unit, 2^30 of the lower one's. */
    return dg_motion_exact_moved(self->from, backwards,
                                 (dg_product((uint32_t)(amplitude >> 32), factor) << 2) +
                                     (dg_product((uint32_t)amplitude, factor) >> SINE_BITS));
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

    return dg_motion_exact_moved(a->angle, backwards,
                                 dg_motion_exact_muldiv(line, t - a->at, b->at - a->at, backwards));
}

dg_angle dg_motion_angle_at(const struct dg_motion *self, dg_ns now)
{
    dg_ns t = dg_elapsed(now, self->start);
    struct travel_time time;

    switch (self->kind) {
    case DG_MOTION_SPEED:
        time = travel_time(t, 0);
        return at_full_speed(self, &time);
    case DG_MOTION_RAMP:
        time = ramp_time(self, t);
        return at_full_speed(self, &time);
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

dg_angle dg_motion_angle(void *ctx, dg_ns now)
{
    return dg_motion_angle_at(ctx, now);
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

static bool is_motion_in_range(const struct dg_motion *self)
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
    if (!is_motion_in_range(wanted)) {
        return DG_ERR_ARGUMENT;
    }
    *self = *wanted;
    self->ready = (struct dg_motion_ready){0};
    make_rate(&self->ready, self->mrpm);
    if (self->kind == DG_MOTION_RAMP || self->kind == DG_MOTION_SINE) {
        self->ready.of = self->kind == DG_MOTION_RAMP ? self->accel : self->period;
        self->ready.by = dg_reciprocal_of(self->ready.of);
    }
    return DG_OK;
}
