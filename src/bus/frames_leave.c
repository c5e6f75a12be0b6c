/* SPDX-License-Identifier: MIT */
/*
 * An encoder leaves the bus. What its controller has not got rid of goes with it; what was on the
 * wire already, and others have yet to hear, stays: then nobody has sent it.
 */
#include "frames_private.h"

/* Those in `list` go on by the places to come: what the encoder at `gone` has sent is of nobody, or
 * leaves the list. */
static void renumber_frames(struct frames_wire *wire, struct frames_list *list, size_t gone,
                            bool stays)
{
    for (uint16_t left = list->count; left > 0; left--) {
        const struct dg_bus_frames_room frame = dg_bus_room_fetch(wire, list);
        const bool behind = frame.from > gone && frame.from < DG_BUS_FRAMES_ENCODERS;
        size_t from = behind ? frame.from - 1u : frame.from;

        from = frame.from == gone ? DG_BUS_FRAMES_ENCODERS : from;
        if (frame.from != gone || stays) {
            (void)dg_bus_room_add(wire, list, from, frame.at, &frame.frame);
        }
    }
}

static void drop_answers(struct frames_wire *wire, struct frames_place *place)
{
    while (place->answers.count > 0) {
        (void)dg_bus_room_fetch(wire, &place->answers);
    }
}

/* It finds that nobody acknowledges, and what it says to that gets nowhere. */
void dg_bus_frames_detach(struct bus_place *base)
{
    struct frames_place *place = (struct frames_place *)(void *)base;
    struct frames_wire *wire = dg_bus_frames_wire(base->bus);

    place->hears = false;
    dg_bus_frames_tell_presence(place);
    drop_answers(wire, place);
    renumber_frames(wire, &wire->heard, base->index, true);
    renumber_frames(wire, &wire->held, base->index, false);
    renumber_frames(wire, &wire->sending, base->index, false);
    dg_bus_room_settle(wire);
}

/* When something is due, who listens and how fast the bus is may have been the encoder's to say. */
void dg_bus_frames_moved(struct dg_bus *self, size_t from)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    (void)from;
    wire->passed = true;
    wire->retuned = true;
    dg_bus_filter_list_all(self);
}
