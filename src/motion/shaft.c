/* SPDX-License-Identifier: MIT */
/*
 * Every command becomes up to four phases of constant acceleration, and every phase is exact:
 *
 *   speed in 10^-12 rpm ("prpm"), so that 0.001 rpm/s are 1 prpm per nanosecond;
 *   distance in halves of prpm * ns, so that t ns from speed v to speed w are t * (v + w) of them;
 *   2 * PARTS_PER_HALF = 512 parts of DG_SHAFT_PARTS are a prpm * ns, as
 *   2^32 / (60 s * 10^9 ns/s * 10^12) = 2^9 / (3 * 5^22).
 *
 * A phase begins and ends at whole nanoseconds, although the moment at which a speed is reached is
 * none: the phase after it then begins where the shaft is at the next one.
 *
 * Ranges: speeds are within +-SPEED_MAX = 10^18 (2^60), accelerations below 2^40. Speeds at the end
 * of a phase are beyond that by less than an acceleration, so a sum of two is within +-2^61. A
 * change of speed takes at most 2 * 10^18 ns. Distances: between two angles below 2^64 * 2^45, to
 * stop below SPEED_MAX^2 = 2^120, together within 128 bits of two's complement.
 */
#include "drehgeber/shaft.h"

#include "drehgeber/hal.h"
#include "motion_private.h"

#define PRPM_PER_MRPM 1000000000
#define SPEED_MAX ((int64_t)DG_MOTION_SPEED_MAX_MRPM * PRPM_PER_MRPM)
#define PARTS_PER_HALF 256u
/** A smaller step, in 2^-32 turn, changes no measured speed: it is a 64th of a count. */
#define JUMP_MIN UINT64_C(1024)
/** 1 turn in DG_WORLD_SPEED_SPAN, in 0.001 rpm. */
#define MRPM_PER_TURN (DG_S(60) / DG_WORLD_SPEED_SPAN * 1000u)

/** What a move is to do, in prpm and ns. */
struct goal {
    dg_angle target;
    uint64_t limit; /**< greatest speed, 1..SPEED_MAX */
    uint64_t accel; /**< 0: at once */
};

/** `value` with the sign that a direction gives it. */
static int64_t directed(bool backwards, uint64_t value)
{
    return backwards ? -(int64_t)value : (int64_t)value;
}

/** Of DG_SHAFT_PARTS. */
#define PARTS_SHIFT 11
static const struct dg_reciprocal by_parts = {
    .divisor = DG_SHAFT_PARTS << PARTS_SHIFT,
    .inverse = UINT64_C(0x42615600F94990EC),
    .shift = PARTS_SHIFT,
};

/** floor(value / DG_SHAFT_PARTS), mostly 0: for 82 days of nanoseconds. */
static uint64_t divided(uint64_t value, uint64_t *rest)
{
    if (value < DG_SHAFT_PARTS) {
        *rest = value;
        return 0;
    }
    const struct dg_wide shifted = {.high = value >> (64 - PARTS_SHIFT),
                                    .low = value << PARTS_SHIFT};
    const uint64_t quotient = dg_divide_by(shifted, &by_parts, rest);
    *rest >>= PARTS_SHIFT;
    return quotient;
}

/** Move an angle with its part by t * sum halves, both ways exactly, modulo 2^64 units. */
static void travel_from(dg_angle *from, uint64_t *part, dg_ns t, int64_t sum)
{
    bool backwards = sum < 0;
    uint64_t speed = dg_motion_exact_magnitude(sum);
    /* t * PARTS_PER_HALF = whole * DG_SHAFT_PARTS + rest; the product of rest and speed divided by
     * DG_SHAFT_PARTS is below speed and so fits 64 bits. */
    uint64_t left;
    uint64_t rest;
    uint64_t parts;
    uint64_t whole = divided(t, &left) * PARTS_PER_HALF;

    whole += divided(left * PARTS_PER_HALF, &rest);
    uint64_t units = dg_divide_by(dg_wide_product(rest << PARTS_SHIFT, speed), &by_parts, &parts);

    parts >>= PARTS_SHIFT;

    if (backwards && *part < parts) {
        units++;
        *part += DG_SHAFT_PARTS;
    }
    *part = backwards ? *part - parts : *part + parts;
    if (*part >= DG_SHAFT_PARTS) {
        units++;
        *part -= DG_SHAFT_PARTS;
    }
    *from = dg_motion_exact_moved(*from, backwards, whole * speed + units);
}

/** The same for a phase's beginning. */
static void travel(struct dg_shaft_phase *self, dg_ns t, int64_t sum)
{
    travel_from(&self->from, &self->part, t, sum);
}

/** The same phase, told from `t` after its beginning on. */
static struct dg_shaft_phase later(const struct dg_shaft_phase *self, dg_ns t)
{
    struct dg_shaft_phase result = *self;
    /* Without an acceleration `t` may be anything; with one the product is a change of speed. */
    int64_t change = (int64_t)((uint64_t)self->mrpm_per_s * t);

    result.at = dg_after(self->at, t);
    result.prpm = self->prpm + change;
    travel(&result, t, self->prpm + result.prpm);
    return result;
}

/** The same phase, told as it would have been at `at`, before its beginning, at a constant speed.
 */
static struct dg_shaft_phase earlier(const struct dg_shaft_phase *self, dg_ns at)
{
    struct dg_shaft_phase result = *self;

    travel(&result, self->at - at, -2 * self->prpm);
    result.at = at;
    return result;
}

/** The phase that says where the shaft is at `now`. */
static const struct dg_shaft_phase *phase_of(const struct dg_shaft_course *self, dg_ns now)
{
    size_t i = self->count - 1u;

    while (i > 0 && self->phase[i].at > now) {
        i--;
    }
    return &self->phase[i];
}

/** Where and how fast the shaft is at `now` by its phases. */
static struct dg_shaft_phase phase_at(const struct dg_shaft_course *self, dg_ns now)
{
    const struct dg_shaft_phase *phase = phase_of(self, now);

    return phase->at > now ? earlier(phase, now) : later(phase, now - phase->at);
}

/** Where only: every latch wants that, and a phase is 40 bytes to copy. */
static dg_angle phase_angle(const struct dg_shaft_course *self, dg_ns now)
{
    const struct dg_shaft_phase *phase = phase_of(self, now);

    if (phase->at > now) {
        return phase_at(self, now).from;
    }
    const dg_ns t = now - phase->at;
    const int64_t change = (int64_t)((uint64_t)phase->mrpm_per_s * t);
    dg_angle from = phase->from;
    uint64_t part = phase->part;

    travel_from(&from, &part, t, phase->prpm + (phase->prpm + change));
    return from;
}

/** The speed of `travel` in DG_WORLD_SPEED_SPAN, to the nearest. */
static int32_t mean_mrpm(uint64_t travel)
{
    /* 36 turns are above the limit already, and below them the product fits 64 bits. */
    uint64_t mrpm =
        travel / DG_TURN < 36 ? (travel * MRPM_PER_TURN + DG_TURN / 2) / DG_TURN : INT32_MAX;

    return mrpm < INT32_MAX ? (int32_t)mrpm : INT32_MAX;
}

static int32_t played_mrpm(const struct dg_shaft_course *self, dg_ns now)
{
    struct dg_motion motion = self->motion;
    dg_ns until = dg_elapsed(now, self->at);

    if (motion.kind == DG_MOTION_SPEED) {
        return motion.mrpm; /* the mean of angles rounded down need not be it */
    }
    motion.start = 0;
    until = until > DG_WORLD_SPEED_SPAN ? until : DG_WORLD_SPEED_SPAN;
    /* Modulo 2^64: the speed stays right where the angle's type wraps. */
    uint64_t travel = (uint64_t)dg_motion_angle(&motion, until) -
                      (uint64_t)dg_motion_angle(&motion, until - DG_WORLD_SPEED_SPAN);

    return travel <= INT64_MAX ? mean_mrpm(travel) : -mean_mrpm(0 - travel);
}

/** Where and how fast the shaft is at `now` by its motion, without acceleration. */
static struct dg_shaft_phase played_at(const struct dg_shaft_course *self, dg_ns now)
{
    struct dg_shaft_phase result = {.at = now, .from = dg_motion_angle_at(&self->motion, now)};

    result.prpm = (int64_t)played_mrpm(self, now) * PRPM_PER_MRPM;
    /* A replay may jump; what it is followed by does not. */
    if (result.prpm > SPEED_MAX) {
        result.prpm = SPEED_MAX;
    } else if (result.prpm < -SPEED_MAX) {
        result.prpm = -SPEED_MAX;
    }
    return result;
}

static const struct dg_shaft_course *course_of(const struct dg_shaft *self, dg_ns now)
{
    return now < self->course.at ? &self->before : &self->course;
}

static void append_phase(struct dg_shaft_course *self, const struct dg_shaft_phase *phase)
{
    self->phase[self->count] = *phase;
    self->count++;
}

static void append_rest(struct dg_shaft_course *self, dg_ns at, dg_angle angle)
{
    append_phase(self, &(struct dg_shaft_phase){.at = at, .from = angle});
}

/** It is at `angle` at `now`, and was at `from` until then. Angles are told in whole units, so who
 * tells where it is tells one that is a little off. */
static void note_jump(struct dg_shaft *self, dg_ns now, dg_angle from, dg_angle angle)
{
    if ((uint64_t)angle - (uint64_t)from + JUMP_MIN > 2u * JUMP_MIN) {
        self->jumped = now;
    }
}

/** Begin a new course. @return where and how fast the shaft is at that moment */
static struct dg_shaft_phase begin_motion(struct dg_shaft *self, dg_ns now)
{
    const dg_ns at = now > self->course.at ? now : self->course.at;
    struct dg_shaft_phase start =
        self->course.plays ? played_at(&self->course, at) : phase_at(&self->course, at);

    start.mrpm_per_s = 0;
    /* A course that was replaced at once was never in force. */
    if (at > self->course.at) {
        self->before = self->course;
    }
    self->course = (struct dg_shaft_course){.at = at};
    return start;
}

/** Whole nanoseconds in which `change` of speed is done, and by how much they do too much. */
static dg_ns change_time(uint64_t change, uint64_t accel, uint64_t *excess)
{
    dg_ns time = (change + accel - 1u) / accel;

    *excess = time * accel - change;
    return time;
}

/**
 * The speed is reached within the last nanosecond of the phase, excess / accel before its end. What
 * the phase travels too far from there on, or back when it ends in standstill, in halves; rounded
 * up by less than 4 * 10^-14 unit.
 */
static int64_t excess_way(uint64_t excess, uint64_t accel)
{
    return (int64_t)dg_motion_exact_muldiv(excess, excess, accel, true);
}

/** Append a change of speed. @return where it ends, without acceleration */
static struct dg_shaft_phase append_change(struct dg_shaft_course *self, struct dg_shaft_phase from,
                                           int64_t prpm, uint64_t accel)
{
    bool down = prpm < from.prpm;
    uint64_t excess;

    if (prpm == from.prpm) {
        return from;
    }
    dg_ns time = change_time(dg_motion_exact_magnitude(prpm - from.prpm), accel, &excess);

    from.mrpm_per_s = directed(down, accel);
    append_phase(self, &from);

    struct dg_shaft_phase end = later(&from, time);

    travel(&end, 1, down ? excess_way(excess, accel) : -excess_way(excess, accel));
    end.prpm = prpm;
    end.mrpm_per_s = 0;
    return end;
}

/** Append braking from `prpm` to a standstill exactly at `target`, from `at` on, and the rest. */
static void append_brake(struct dg_shaft_course *self, struct dg_shaft_phase brake,
                         const struct goal *goal)
{
    bool backwards = brake.prpm < 0;
    uint64_t excess;
    dg_ns time = change_time(dg_motion_exact_magnitude(brake.prpm), goal->accel, &excess);

    /* Told from its end: so far before the target that it stops there. */
    brake.from = goal->target;
    brake.part = 0;
    brake.mrpm_per_s = directed(!backwards, goal->accel);
    if (time > 0) {
        travel(&brake, time, -(brake.prpm - directed(backwards, excess)));
        travel(&brake, 1, directed(!backwards, (uint64_t)excess_way(excess, goal->accel)));
        append_phase(self, &brake);
    }
    append_rest(self, dg_after(brake.at, time), goal->target);
}

/** From a phase's beginning to `target` in halves, with sign. */
static struct dg_wide way_to(const struct dg_shaft_phase *self, dg_angle target)
{
    bool backwards = target <= self->from; /* `part` is on top of `from` */
    uint64_t units = backwards ? (uint64_t)self->from - (uint64_t)target
                               : (uint64_t)target - (uint64_t)self->from;
    struct dg_wide parts = dg_wide_product(units, DG_SHAFT_PARTS);
    struct dg_wide part = {0, self->part};
    struct dg_wide way = dg_motion_wide_divide(backwards ? dg_motion_wide_add(parts, part)
                                                         : dg_motion_wide_subtract(parts, part),
                                               PARTS_PER_HALF);

    return backwards ? dg_motion_wide_negate(way) : way;
}

/** What a shaft at `speed` travels until it stands, in halves: speed^2 / accel. */
static struct dg_wide stop_way(uint64_t speed, uint64_t accel)
{
    return dg_motion_wide_divide(dg_wide_product(speed, speed), accel);
}

/** How long `way` halves take at half of `double_speed`, rounded up. */
static dg_ns time_for(struct dg_wide way, uint64_t double_speed)
{
    struct dg_wide time = dg_motion_wide_divide(
        dg_motion_wide_add(way, (struct dg_wide){0, double_speed - 1u}), double_speed);

    return time.high == 0 ? time.low : DG_NEVER;
}

/**
 * What a shaft at `speed` travels further when it goes on to `top` before it brakes, in halves: so
 * much on the way up, and as much more on the way down.
 */
static struct dg_wide way_over(uint64_t top, uint64_t speed, uint64_t accel)
{
    return dg_motion_wide_divide(dg_wide_product(2u * (top - speed), top + speed), accel);
}

/** The speed a move gets to from `speed`, which would stop it `room` before the target. */
static uint64_t top_speed(struct dg_wide room, uint64_t speed, const struct goal *goal)
{
    if (speed >= goal->limit ||
        dg_motion_wide_less(way_over(goal->limit, speed, goal->accel), room)) {
        return goal->limit;
    }
    /* way_over() solved for top; room * accel <= 2 * SPEED_MAX^2, 121 bits */
    return dg_motion_wide_sqrt(
        dg_motion_wide_add(dg_motion_wide_divide(dg_motion_wide_times(room, goal->accel), 2),
                           dg_wide_product(speed, speed)));
}

/** Append the part of a move behind its change to top speed, `way` before braking: hold, brake. */
static void append_approach(struct dg_shaft_course *self, const struct dg_shaft_phase *hold,
                            struct dg_wide way, const struct goal *goal)
{
    bool backwards = hold->prpm < 0;
    uint64_t top = dg_motion_exact_magnitude(hold->prpm);
    /* Braking may have begun in the last nanosecond of the change. */
    dg_ns time = dg_motion_wide_is_negative(way) ? 0 : time_for(way, 2u * top);
    /* It begins within the nanosecond before: some of the speed is gone by then. */
    uint64_t late = time * 2u * top - way.low;
    uint64_t gone = dg_muldiv(goal->accel, late, 2u * top);
    struct dg_shaft_phase brake = {
        .at = dg_after(hold->at, time),
        .prpm = directed(backwards, gone < top ? top - gone : 0),
    };

    append_phase(self, hold);
    append_brake(self, brake, goal);
}

/**
 * A move with an acceleration: with the same one from the present speed to the top speed, which may
 * mean to turn round, and from there to the target. The direction of the top speed is the one from
 * where the shaft would stop to the target.
 */
static void append_move(struct dg_shaft_course *self, const struct dg_shaft_phase *start,
                        const struct goal *goal)
{
    uint64_t speed = dg_motion_exact_magnitude(start->prpm);
    struct dg_wide stop = stop_way(speed, goal->accel);
    struct dg_wide way = dg_motion_wide_subtract(
        way_to(start, goal->target), start->prpm < 0 ? dg_motion_wide_negate(stop) : stop);
    bool backwards = dg_motion_wide_is_negative(way);
    struct dg_wide room = backwards ? dg_motion_wide_negate(way) : way;
    uint64_t excess;

    if (backwards != (start->prpm < 0)) {
        speed = 0; /* it stops, and goes on from there */
    }
    uint64_t top = top_speed(room, speed, goal);
    struct dg_shaft_phase hold = append_change(self, *start, directed(backwards, top), goal->accel);

    if (top == 0) {
        append_rest(self, hold.at, goal->target); /* less than a unit away */
        return;
    }
    if (speed < top) {
        room = dg_motion_wide_subtract(room, way_over(top, speed, goal->accel));
    }
    /* At top speed from the moment at which it is reached to the nanosecond at which it is held. */
    (void)change_time(dg_motion_exact_magnitude(hold.prpm - start->prpm), goal->accel, &excess);
    room = dg_motion_wide_subtract(room,
                                   (struct dg_wide){0, dg_muldiv(2u * top, excess, goal->accel)});
    append_approach(self, &hold, room, goal);
}

/** A move at one speed, from the first moment to the last. */
static void append_move_at_once(struct dg_shaft_course *self, const struct dg_shaft_phase *start,
                                const struct goal *goal)
{
    struct dg_shaft_phase hold = *start;
    struct dg_wide way = way_to(start, goal->target);
    bool backwards = dg_motion_wide_is_negative(way);
    dg_ns time = time_for(backwards ? dg_motion_wide_negate(way) : way, 2u * goal->limit);

    hold.prpm = directed(backwards, goal->limit);
    if (time > 0) {
        append_phase(self, &hold);
    }
    append_rest(self, dg_after(hold.at, time), goal->target);
}

static dg_angle angle_at(const struct dg_shaft *self, dg_ns now);

/** The driver's angle times the ratio, floor. */
static dg_angle geared_angle(const struct dg_shaft *self, dg_ns now)
{
    dg_angle angle = angle_at(self->driver, now);
    bool backwards = (angle < 0) != (self->numerator < 0);
    uint64_t driver = dg_motion_exact_magnitude(angle);
    uint64_t numerator = dg_motion_exact_magnitude(self->numerator);
    uint64_t denominator = (uint64_t)self->denominator;

    return dg_motion_exact_moved(
        0, backwards,
        driver / denominator * numerator +
            dg_motion_exact_muldiv(driver % denominator, numerator, denominator, backwards));
}

static dg_angle angle_at(const struct dg_shaft *self, dg_ns now)
{
    if (self->driver != NULL) {
        return dg_motion_exact_moved(geared_angle(self, now), false, (uint64_t)self->offset);
    }
    const struct dg_shaft_course *course = course_of(self, now);

    if (course->plays) {
        return dg_motion_angle_at(&course->motion, now);
    }
    return phase_angle(course, now);
}

void dg_shaft_init(struct dg_shaft *self)
{
    *self = (struct dg_shaft){0};
    append_rest(&self->course, 0, 0);
    self->before = self->course;
}

int dg_shaft_couple(struct dg_shaft *self, const struct dg_shaft *driver, int32_t numerator,
                    int32_t denominator)
{
    unsigned gears = 0;

    /* The shafts above have no loop, and so none is made when this one is not among them. */
    for (const struct dg_shaft *above = driver; above != NULL; above = above->driver) {
        gears++;
        if (above == self || gears > DG_SHAFT_GEARS_MAX) {
            return DG_ERR_ARGUMENT;
        }
    }
    if (gears == 0 || denominator < 1) {
        return DG_ERR_ARGUMENT;
    }
    self->driver = driver;
    self->numerator = numerator;
    self->denominator = denominator;
    self->offset = 0;
    return DG_OK;
}

int dg_shaft_set_acceleration(struct dg_shaft *self, int64_t mrpm_per_s)
{
    if (self->driver != NULL || mrpm_per_s < 0 || mrpm_per_s > DG_SHAFT_ACCELERATION_MAX) {
        return DG_ERR_ARGUMENT;
    }
    self->mrpm_per_s = mrpm_per_s;
    return DG_OK;
}

int dg_shaft_set_position(struct dg_shaft *self, dg_ns now, dg_angle angle)
{
    if (self->driver != NULL) {
        note_jump(self, now, angle_at(self, now), angle);
        self->offset = dg_motion_exact_moved(angle, true, (uint64_t)geared_angle(self, now));
        return DG_OK;
    }
    const struct dg_shaft_phase start = begin_motion(self, now);

    note_jump(self, start.at, start.from, angle);
    append_rest(&self->course, start.at, angle);
    return DG_OK;
}

int dg_shaft_set_velocity(struct dg_shaft *self, dg_ns now, int32_t mrpm)
{
    if (self->driver != NULL || mrpm < -DG_MOTION_SPEED_MAX_MRPM ||
        mrpm > DG_MOTION_SPEED_MAX_MRPM) {
        return DG_ERR_ARGUMENT;
    }
    struct dg_shaft_phase phase = begin_motion(self, now);
    const int64_t prpm = (int64_t)mrpm * PRPM_PER_MRPM;

    if (self->mrpm_per_s != 0) {
        phase = append_change(&self->course, phase, prpm, (uint64_t)self->mrpm_per_s);
    }
    phase.prpm = prpm;
    append_phase(&self->course, &phase);
    return DG_OK;
}

int dg_shaft_turn(struct dg_shaft *self, dg_ns now, dg_angle angle, int64_t prpm)
{
    if (self->driver != NULL || prpm < -SPEED_MAX || prpm > SPEED_MAX) {
        return DG_ERR_ARGUMENT;
    }
    struct dg_shaft_phase phase = begin_motion(self, now);

    note_jump(self, phase.at, phase.from, angle);
    phase.from = angle;
    phase.part = 0;
    phase.prpm = prpm;
    append_phase(&self->course, &phase);
    return DG_OK;
}

int dg_shaft_move(struct dg_shaft *self, dg_ns now, dg_angle target, int32_t mrpm)
{
    if (self->driver != NULL || mrpm < 1 || mrpm > DG_MOTION_SPEED_MAX_MRPM) {
        return DG_ERR_ARGUMENT;
    }
    const struct dg_shaft_phase start = begin_motion(self, now);
    const struct goal goal = {
        .target = target,
        .limit = (uint64_t)mrpm * PRPM_PER_MRPM,
        .accel = (uint64_t)self->mrpm_per_s,
    };

    if (goal.accel == 0) {
        append_move_at_once(&self->course, &start, &goal);
    } else {
        append_move(&self->course, &start, &goal);
    }
    return DG_OK;
}

int dg_shaft_play(struct dg_shaft *self, dg_ns now, const struct dg_motion *motion)
{
    struct dg_motion accepted;

    if (self->driver != NULL || dg_motion_set(&accepted, motion) != DG_OK) {
        return DG_ERR_ARGUMENT;
    }
    const struct dg_shaft_phase start = begin_motion(self, now);

    self->course.plays = true;
    self->course.motion = accepted;
    self->course.motion.start = self->course.at;
    note_jump(self, start.at, start.from, dg_motion_angle_at(&self->course.motion, start.at));
    return DG_OK;
}

dg_ns dg_shaft_settled(const struct dg_shaft *self)
{
    if (self->driver != NULL) {
        return dg_shaft_settled(self->driver);
    }
    return self->course.plays ? DG_NEVER : self->course.phase[self->course.count - 1u].at;
}

/** In 0.001 rpm, rounded up. */
static uint32_t mrpm_above(int64_t prpm)
{
    const uint64_t magnitude = dg_motion_exact_magnitude(prpm);

    return (uint32_t)((magnitude + PRPM_PER_MRPM - 1u) / PRPM_PER_MRPM);
}

/** The highest speed from `from` on: that of a phase changes evenly. */
static uint32_t fastest_phase(const struct dg_shaft_course *self, dg_ns from)
{
    const struct dg_shaft_phase *end = &self->phase[self->count];
    uint32_t most = 0;

    for (const struct dg_shaft_phase *at = phase_of(self, from); at < end; at++) {
        const uint32_t mrpm = mrpm_above(at->prpm);
        most = mrpm > most ? mrpm : most;
    }
    return most;
}

static uint32_t fastest_played(const struct dg_motion *self)
{
    if (self->kind == DG_MOTION_STANDSTILL) {
        return 0;
    }
    return self->kind == DG_MOTION_SPEED || self->kind == DG_MOTION_RAMP
               ? (uint32_t)dg_motion_exact_magnitude(self->mrpm)
               : UINT32_MAX;
}

static uint32_t fastest_of(const struct dg_shaft_course *self, dg_ns from)
{
    return self->plays ? fastest_played(&self->motion) : fastest_phase(self, from);
}

/** The highest speed from `from` on, in 0.001 rpm, rounded up. */
static uint32_t fastest(const struct dg_shaft *self, dg_ns from)
{
    if (self->driver != NULL) {
        const uint64_t mrpm =
            fastest(self->driver, from) * dg_motion_exact_magnitude(self->numerator);
        const uint64_t denominator = (uint64_t)self->denominator;
        const uint64_t geared = (mrpm + denominator - 1u) / denominator;
        return geared < UINT32_MAX ? (uint32_t)geared : UINT32_MAX;
    }
    const uint32_t most = fastest_of(&self->course, from);
    const uint32_t before = from < self->course.at ? fastest_of(&self->before, from) : 0;

    return before > most ? before : most;
}

/** Neither it nor a shaft that drives it has jumped since `then`. */
static bool is_smooth_since(const struct dg_shaft *self, dg_ns then)
{
    while (self->jumped <= then && self->driver != NULL) {
        self = self->driver;
    }
    return self->jumped <= then;
}

enum dg_calm dg_shaft_calm(void *ctx, dg_ns now)
{
    const struct dg_shaft *self = ctx;
    const dg_ns then = dg_elapsed(now, DG_WORLD_SPEED_SPAN);

    if (now < DG_WORLD_SPEED_SPAN || !is_smooth_since(self, then)) {
        return DG_CALM_UNKNOWN;
    }
    const uint32_t mrpm = fastest(self, then);
    if (mrpm == 0) {
        return DG_CALM_STANDS;
    }
    return mrpm <= DG_CALM_MRPM ? DG_CALM_SLOW : DG_CALM_UNKNOWN;
}

dg_angle dg_shaft_angle(void *ctx, dg_ns now)
{
    return angle_at(ctx, now);
}

int32_t dg_shaft_mrpm(const struct dg_shaft *self, dg_ns now)
{
    if (self->driver == NULL) {
        const struct dg_shaft_course *course = course_of(self, now);

        return course->plays ? played_mrpm(course, now)
                             : (int32_t)(phase_at(course, now).prpm / PRPM_PER_MRPM);
    }
    int64_t mrpm = (int64_t)dg_shaft_mrpm(self->driver, now) * self->numerator / self->denominator;

    if (mrpm > INT32_MAX) {
        return INT32_MAX;
    }
    return mrpm < -INT32_MAX ? -INT32_MAX : (int32_t)mrpm;
}
