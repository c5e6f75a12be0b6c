/* SPDX-License-Identifier: MIT */
/*
 * Sine and cosine of the encoders of an RS485 line, for whoever asks the tap for them.
 *
 * They are functions of time: a timer that comes round every 10 ms reads what they were at every
 * sampling point since. A change of the shaft comes in between, but the shaft still knows then
 * where it was. Levels that have not changed are not told.
 */
#include <string.h>

#include "hf_line.h"

#define ROUND DG_MS(10)
/* More than this behind: what was before is left out. */
#define BEHIND_MAX DG_MS(100)

static bool samples(const struct lx_hf_drop *self)
{
    return self->settings.sincos > 0;
}

/* The first of an encoder's sampling points, whole multiples of its interval, after `at`. */
static dg_ns point_after(const struct lx_hf_drop *self, dg_ns at)
{
    return at - at % self->settings.sincos + self->settings.sincos;
}

/* Without power there is no voltage. */
static void tell(struct lx_hf_drop *self, size_t place, dg_ns at)
{
    struct dg_tap_event event = {.at = at, .kind = DG_TAP_SINCOS, .ours = true};
    event.sincos.encoder = place;
    if (lx_hf_powered(self)) {
        struct dg_hf_sincos lines;
        dg_hf_sincos(&self->device, at, &lines);
        event.sincos.uv[0] = lines.sin_plus_uv;
        event.sincos.uv[1] = lines.sin_minus_uv;
        event.sincos.uv[2] = lines.cos_plus_uv;
        event.sincos.uv[3] = lines.cos_minus_uv;
    }
    if (!self->drawn || memcmp(event.sincos.uv, self->uv, sizeof self->uv) != 0) {
        self->drawn = true;
        memcpy(self->uv, event.sincos.uv, sizeof self->uv);
        lx_tap_tell(&self->all->bus.tap, &event);
    }
}

/* A trace has begun: all levels as they are now, then from point to point. */
static void begin(struct lx_hf_bus *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        struct lx_hf_drop *drop = &self->drop[i];
        if (samples(drop)) {
            drop->drawn = false;
            drop->point = point_after(drop, now);
            tell(drop, i, now);
        }
    }
}

static void catch_up(struct lx_hf_bus *self, dg_ns now)
{
    const dg_ns oldest = dg_elapsed(now, BEHIND_MAX);
    for (;;) {
        size_t first = self->count;
        for (size_t i = 0; i < self->count; i++) {
            const bool earlier =
                first == self->count || self->drop[i].point < self->drop[first].point;
            first = samples(&self->drop[i]) && earlier ? i : first;
        }
        if (first == self->count || self->drop[first].point > now) {
            return;
        }
        struct lx_hf_drop *drop = &self->drop[first];
        if (drop->point < oldest) {
            drop->point = point_after(drop, oldest);
            continue;
        }
        tell(drop, first, drop->point);
        drop->point += drop->settings.sincos;
    }
}

dg_ns lx_hf_sample(struct lx_hf_bus *self, dg_ns now)
{
    const bool asked = lx_tap_asked(&self->bus.tap);
    if (asked && !self->sampling) {
        begin(self, now);
    } else if (asked) {
        catch_up(self, now);
    }
    self->sampling = asked;
    return asked ? dg_after(now, ROUND) : DG_NEVER;
}
