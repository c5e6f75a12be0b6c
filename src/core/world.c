/* SPDX-License-Identifier: MIT */
#include "drehgeber/world.h"

#include "drehgeber/quantity.h"

/** 1 turn in DG_WORLD_SPEED_SPAN, in 0.001 rpm. */
#define MRPM_PER_TURN (DG_S(60) / DG_WORLD_SPEED_SPAN * 1000u)

static dg_angle at_rest(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return 0;
}

#define HEALTHY(id, member, name, header, unit, healthy, ...) .member = healthy,

void dg_world_init(struct dg_world *self)
{
    *self = (struct dg_world){.angle = at_rest, DG_QUANTITIES(HEALTHY)};
}

dg_angle dg_world_angle(const struct dg_world *self, dg_ns now)
{
    return self->angle(self->angle_ctx, now);
}

/** The speed of `travel` in DG_WORLD_SPEED_SPAN. */
static int32_t speed_mrpm(uint64_t travel)
{
    /* 36 turns are above the limit already, and below them the product fits 64 bits. */
    uint64_t mrpm = travel / DG_TURN < 36 ? travel * MRPM_PER_TURN / DG_TURN : INT32_MAX;

    return mrpm < INT32_MAX ? (int32_t)mrpm : INT32_MAX;
}

int32_t dg_world_moving(const struct dg_world *self, dg_ns now, dg_angle *angle)
{
    dg_angle until = self->angle(self->angle_ctx, now);
    dg_angle since;

    *angle = until;
    if (now > DG_WORLD_SPEED_SPAN) {
        since = self->angle(self->angle_ctx, now - DG_WORLD_SPEED_SPAN);
    } else {
        until = self->angle(self->angle_ctx, DG_WORLD_SPEED_SPAN);
        since = self->angle(self->angle_ctx, 0);
    }
    /* Modulo 2^64: the speed stays right where the angle's type wraps. */
    const uint64_t travel = (uint64_t)until - (uint64_t)since;
    return travel <= INT64_MAX ? speed_mrpm(travel) : -speed_mrpm(0 - travel);
}

int32_t dg_world_speed_mrpm(const struct dg_world *self, dg_ns now)
{
    dg_angle angle;

    return dg_world_moving(self, now, &angle);
}

enum dg_calm dg_world_calm(const struct dg_world *self, dg_ns now)
{
    return self->calm != NULL ? self->calm(self->angle_ctx, now) : DG_CALM_UNKNOWN;
}

static bool amplitude_ok(uint16_t permille, const struct dg_signal_limits *limits)
{
    return permille >= limits->amplitude_min_permille && permille <= limits->amplitude_max_permille;
}

static bool offset_ok(int16_t permille, const struct dg_signal_limits *limits)
{
    return permille >= -limits->offset_max_permille && permille <= limits->offset_max_permille;
}

bool dg_world_signals_ok(const struct dg_world *self, const struct dg_signal_limits *limits)
{
    return amplitude_ok(self->sin_amplitude_permille, limits) &&
           amplitude_ok(self->cos_amplitude_permille, limits) &&
           offset_ok(self->sin_offset_permille, limits) &&
           offset_ok(self->cos_offset_permille, limits);
}
