/* SPDX-License-Identifier: MIT */
/*
 * Sine and cosine of the encoders of a line, for whoever asks the tap for them.
 *
 * They are functions of time: a timer that comes round every 10 ms reads what they were at every
 * sampling point since. A change of the shaft comes in between, but the shaft still knows then
 * where it was. Levels that have not changed are not told.
 */
#include <string.h>

#include "line_bus.h"

#define ROUND DG_MS(10)
/* More than this behind: what was before is left out. */
#define BEHIND_MAX DG_MS(100)

static bool samples(const struct lx_line_encoder *self)
{
    int32_t uv[4];
    return self->sincos > 0 && dg_host_sincos(self->station->host, 0, uv) != DG_HOST_ERR_WIRE;
}

/* The first of an encoder's sampling points, whole multiples of its interval, after `at`. */
static dg_ns point_after(const struct lx_line_encoder *self, dg_ns at)
{
    return at - at % self->sincos + self->sincos;
}

/* Without power there is no voltage. */
static void report_levels(struct lx_line_encoder *self, size_t place, dg_ns at)
{
    struct dg_tap_event event = {.at = at, .kind = DG_TAP_SINCOS, .ours = true};
    event.sincos.encoder = place;
    (void)dg_host_sincos(self->station->host, at, event.sincos.uv);
    if (!self->drawn || memcmp(event.sincos.uv, self->uv, sizeof self->uv) != 0) {
        self->drawn = true;
        memcpy(self->uv, event.sincos.uv, sizeof self->uv);
        lx_tap_tell(&self->all->bus.tap, &event);
    }
}

/* A trace has begun: all levels as they are now, then from point to point. */
static void begin_levels(struct lx_line_bus *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        struct lx_line_encoder *encoder = &self->encoder[i];
        if (samples(encoder)) {
            encoder->drawn = false;
            encoder->point = point_after(encoder, now);
            report_levels(encoder, i, now);
        }
    }
}

static void catch_up_levels(struct lx_line_bus *self, dg_ns now)
{
    const dg_ns oldest = dg_elapsed(now, BEHIND_MAX);
    for (;;) {
        size_t first = self->count;
        for (size_t i = 0; i < self->count; i++) {
            const bool earlier =
                first == self->count || self->encoder[i].point < self->encoder[first].point;
            first = samples(&self->encoder[i]) && earlier ? i : first;
        }
        if (first == self->count || self->encoder[first].point > now) {
            return;
        }
        struct lx_line_encoder *encoder = &self->encoder[first];
        if (encoder->point < oldest) {
            encoder->point = point_after(encoder, oldest);
            continue;
        }
        report_levels(encoder, first, encoder->point);
        encoder->point += encoder->sincos;
    }
}

dg_ns lx_line_sample(struct lx_line_bus *self, dg_ns now)
{
    const bool asked = lx_tap_asked(&self->bus.tap);
    if (asked && !self->sampling) {
        begin_levels(self, now);
    } else if (asked) {
        catch_up_levels(self, now);
    }
    self->sampling = asked;
    return asked ? dg_after(now, ROUND) : DG_NEVER;
}
