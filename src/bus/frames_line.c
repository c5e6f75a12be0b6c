/* SPDX-License-Identifier: MIT */
/*
 * Bit rates: an encoder whose own is not the wire's lives on, deaf and mute. What it sends from the
 * change on already is at its new rate.
 */
#include "frames_private.h"

static bool fits_bit_rate(const struct dg_bus_frames_line *line, uint32_t bit_rate)
{
    return !line->closed &&
           (line->tolerant || line->bit_rate == 0 || bit_rate == 0 || line->bit_rate == bit_rate);
}

/* The wire's own, or where it has none that of the slowest encoder that hears it. */
static void find_bit_rate(const struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    uint32_t slowest = wire->setup.line.bit_rate;

    for (size_t i = 0; wire->setup.line.bit_rate == 0 && i < self->count; i++) {
        const struct frames_place *place = dg_bus_frames_at(self, i);
        if (place->hears && place->bit_rate != 0 && (slowest == 0 || place->bit_rate < slowest)) {
            slowest = place->bit_rate;
        }
    }
    wire->bit_rate = slowest;
}

static void use_bit_rate(struct frames_place *place, uint32_t bit_rate)
{
    const struct dg_bus *self = place->base.bus;
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const struct dg_bus_frames_ops *ops = wire->setup.ops;

    place->bit_rate = bit_rate;
    wire->retuned = true;
    if (ops != NULL && ops->retuned != NULL) {
        ops->retuned(self->ctx, place->base.index, bit_rate);
    }
    place->hears = fits_bit_rate(&wire->setup.line, bit_rate);
    if (place->hears && wire->setup.line.bit_rate == 0 &&
        (wire->bit_rate == 0 || bit_rate < wire->bit_rate)) {
        wire->bit_rate = bit_rate; /* until all are asked */
    }
}

void dg_bus_line_follow(struct frames_place *place, uint32_t version)
{
    const uint32_t bit_rate = place->ask->bit_rate(place->device);

    place->version = version;
    if (bit_rate != place->bit_rate) {
        use_bit_rate(place, bit_rate);
    }
    dg_bus_filter_list(dg_bus_frames_wire(place->base.bus), place);
}

void dg_bus_line_tune(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    for (size_t i = 0; i < self->count; i++) {
        struct frames_place *place = dg_bus_frames_at(self, i);
        place->hears = fits_bit_rate(&wire->setup.line, place->bit_rate);
        dg_bus_filter_list(wire, place);
    }
    find_bit_rate(self);
    wire->retuned = false;
    wire->unsure = true;
}

bool dg_bus_line_has_bus(const struct frames_wire *self, const struct frames_place *place)
{
    return place->hears && self->setup.line.company != DG_BUS_NOBODY;
}

bool dg_bus_frames_set_line(struct dg_bus *self, const struct dg_bus_frames_line *line)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const struct dg_bus_frames_line *before = &wire->setup.line;

    const bool differs = line->bit_rate != before->bit_rate || line->tolerant != before->tolerant ||
                         line->closed != before->closed || line->company != before->company;

    if (differs) {
        wire->setup.line = *line;
        wire->retuned = true;
    }
    return differs;
}

bool dg_bus_frames_hears(const struct dg_bus *self, size_t place)
{
    return dg_bus_frames_at(self, place)->hears;
}

uint32_t dg_bus_frames_bit_rate(const struct dg_bus *self)
{
    return dg_bus_frames_wire(self)->bit_rate;
}
