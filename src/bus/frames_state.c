/* SPDX-License-Identifier: MIT */
/*
 * What is in a state of a bus of frames: the wire, its controller, and frames that wait, each list
 * in its order, wherever they are in the host's memory. Who listens to what, at which bit rate and
 * until when follows from the encoders.
 */
#include "bus_tape.h"
#include "frames_private.h"

#define DLC_MAX 8u

static const struct bus_member wire_rows[] = {
    BUS_ANY(frames_wire, setup.line.bit_rate),
    BUS_BOOL(frames_wire, setup.line.tolerant),
    BUS_BOOL(frames_wire, setup.line.closed),
    BUS_MEMBER(frames_wire, setup.line.company, DG_BUS_NOBODY),
    BUS_ANY(frames_wire, busy_until),
    BUS_ANY(frames_wire, bits),
    BUS_ANY(frames_wire, counters.stalls),
    BUS_ANY(frames_wire, counters.lost),
    BUS_ANY(frames_wire, bit_rate),
    BUS_MEMBER(frames_wire, state, DG_CONTROLLER_OFF),
    BUS_BOOL(frames_wire, full),
    BUS_BOOL(frames_wire, retuned),
    BUS_BOOL(frames_wire, unsure),
};

static const struct bus_member frame_rows[] = {
    BUS_ANY(dg_bus_frames_room, at),
    BUS_MEMBER(dg_bus_frames_room, frame.id, FRAMES_IDS - 1u),
    BUS_BOOL(dg_bus_frames_room, frame.rtr),
    BUS_MEMBER(dg_bus_frames_room, frame.dlc, DLC_MAX),
    BUS_ANY(dg_bus_frames_room, frame.data),
    BUS_ANY(dg_bus_frames_room, from),
};

static const struct bus_member place_rows[] = {
    BUS_ANY(frames_place, last_held),
    BUS_BOOL(frames_place, hears),
};

/* What an encoder that has left has sent is of nobody, and others may still hear it. */
static bool is_of_encoder(const struct dg_bus *self, const struct frames_list *list, uint8_t from)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);

    return from < self->count || (list == &wire->heard && from == DG_BUS_FRAMES_ENCODERS);
}

/* Late frames go out in the future, all others have been said. */
static bool is_in_time(const struct frames_wire *wire, const struct frames_list *list, dg_ns at,
                       dg_ns now)
{
    return list == &wire->held ? at >= now : at <= now;
}

static void pass_list(const struct dg_bus *self, struct bus_tape *tape, struct frames_list *list)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const size_t count = dg_bus_tape_length(tape, list->count, wire->setup.rooms);
    uint16_t next = list->first;

    if (tape->way == BUS_TAPE_RESTORE) {
        *list = (struct frames_list){0};
    }
    for (size_t i = 0; i < count; i++) {
        struct dg_bus_frames_room frame = {0};
        if (tape->way == BUS_TAPE_SAVE) {
            frame = wire->setup.room[next - 1u];
            next = frame.next;
        }
        dg_bus_tape_members(tape, frame_rows, DG_COUNT(frame_rows), &frame, &frame);
        dg_bus_tape_expect(tape, is_of_encoder(self, list, frame.from) &&
                                     is_in_time(wire, list, frame.at, tape->now));
        if (tape->way == BUS_TAPE_RESTORE) {
            (void)dg_bus_room_add(wire, list, frame.from, frame.at, &frame.frame);
        }
    }
    tape->rooms += count;
    dg_bus_tape_expect(tape, tape->rooms <= wire->setup.rooms);
}

void dg_bus_frames_pass_wire(const struct dg_bus *self, struct bus_tape *tape)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    dg_bus_tape_members(tape, wire_rows, DG_COUNT(wire_rows), wire, dg_bus_tape_into(tape, wire));
    if (tape->way == BUS_TAPE_RESTORE) {
        wire->unused = (struct frames_list){0};
        wire->used = 0;
    }
    pass_list(self, tape, &wire->heard);
    pass_list(self, tape, &wire->held);
    pass_list(self, tape, &wire->sending);
}

/* Its deadline is its handle's; it has another one before the bus was told of a change. */
void dg_bus_frames_pass_place(struct bus_place *base, struct bus_tape *tape)
{
    struct frames_place *place = (struct frames_place *)(void *)base;

    dg_bus_tape_expect(tape, tape->way != BUS_TAPE_SAVE || place->due == dg_host_next(base->host));
    dg_bus_tape_members(tape, place_rows, DG_COUNT(place_rows), place,
                        dg_bus_tape_into(tape, place));
    pass_list(base->bus, tape, &place->answers);
}

static void count_held(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);
    uint16_t next = wire->held.first;

    for (size_t i = 0; i < self->count; i++) {
        dg_bus_frames_at(self, i)->held = 0;
    }
    for (uint16_t left = wire->held.count; left > 0; left--) {
        const struct dg_bus_frames_room *late = &wire->setup.room[next - 1u];
        dg_bus_frames_at(self, late->from)->held++;
        next = late->next;
    }
}

/* The host is told of nothing: it knows that filters are others. */
void dg_bus_frames_restored(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    wire->soonest = DG_NEVER;
    wire->passed = false;
    for (size_t i = 0; i < self->count; i++) {
        struct frames_place *place = dg_bus_frames_at(self, i);
        place->due = dg_host_next(place->base.host);
        place->version = place->ask->version(place->device);
        place->bit_rate = place->ask->bit_rate(place->device);
        wire->soonest = dg_earliest(wire->soonest, place->due);
    }
    count_held(self);
    dg_bus_room_settle(wire);
    dg_bus_filter_list_all(self);
    wire->refiltered = false;
}
