/* SPDX-License-Identifier: MIT */
/*
 * What is in a state of a line of characters: what is on the line, and replies.
 */
#include "bus_tape.h"
#include "characters_private.h"

static const struct bus_member line_rows[] = {
    BUS_ANY(characters_line, counters.collided),
    BUS_ANY(characters_line, counters.late),
    BUS_ANY(characters_line, counters.overrun),
    BUS_ANY(characters_line, heard),
};

static const struct bus_member coming_rows[] = {
    BUS_ANY(characters_coming, end),      BUS_ANY(characters_coming, baud),
    BUS_ANY(characters_coming, parity),   BUS_ANY(characters_coming, byte),
    BUS_BOOL(characters_coming, damaged),
};

static const struct bus_member place_rows[] = {
    BUS_ANY(characters_place, uart.baud),
    BUS_ANY(characters_place, uart.parity),
    BUS_ANY(characters_place, uart.timeout_bits),
    BUS_ANY(characters_place, pace.baud),
    BUS_ANY(characters_place, pace.parity),
    BUS_ANY(characters_place, pace.rest),
    BUS_ANY(characters_place, pace.whole),
    BUS_ANY(characters_place, missed),
    BUS_BOOL(characters_place, deaf),
    BUS_BOOL(characters_place, kept),
    BUS_MEMBER(characters_place, said, DG_REPLY_MAX),
    BUS_ANY(characters_place, saying),
    BUS_ANY(characters_place, reply.pace.baud),
    BUS_ANY(characters_place, reply.pace.parity),
    BUS_ANY(characters_place, reply.pace.rest),
    BUS_ANY(characters_place, reply.pace.whole),
    BUS_ANY(characters_place, reply.next),
    BUS_ANY(characters_place, reply.start),
    BUS_ANY(characters_place, reply.from),
    BUS_ANY(characters_place, reply.to),
    BUS_ANY(characters_place, reply.floor),
    BUS_ANY(characters_place, reply.rest),
    BUS_ANY(characters_place, reply.bytes),
    BUS_MEMBER(characters_place, reply.length, DG_REPLY_MAX),
    BUS_MEMBER(characters_place, reply.sent, DG_REPLY_MAX),
    BUS_ANY(characters_place, reply.damaged),
    BUS_BOOL(characters_place, reply.begun),
    BUS_BOOL(characters_place, reply.again),
    BUS_BOOL(characters_place, reply.merged),
};

/* Characters come in the order of their ends, none before the present, the last at line->end. */
static void pass_coming(struct characters_line *line, struct bus_tape *tape)
{
    const size_t count = dg_bus_tape_length(tape, line->count, DG_COMING_MAX);
    const dg_ns end = dg_bus_tape_moment(tape, line->end);
    const bool restores = tape->way == BUS_TAPE_RESTORE;
    dg_ns latest = tape->now;

    for (size_t i = 0; i < count; i++) {
        const size_t at = restores ? i : (line->first + i) % DG_COMING_MAX;
        struct characters_coming copy = line->coming[at];
        dg_bus_tape_members(tape, coming_rows, DG_COUNT(coming_rows), &line->coming[at], &copy);
        dg_bus_tape_expect(tape, copy.end >= latest);
        latest = copy.end;
        if (restores) {
            line->coming[i] = copy;
        }
    }
    dg_bus_tape_expect(tape, count == 0 || latest == end);
    if (restores) {
        line->first = 0;
        line->count = count;
        line->end = end;
    }
}

void dg_bus_characters_pass_wire(const struct dg_bus *self, struct bus_tape *tape)
{
    struct characters_line *line = characters_line_of(self);

    dg_bus_tape_members(tape, line_rows, DG_COUNT(line_rows), line, dg_bus_tape_into(tape, line));
    pass_coming(line, tape);
}

/* Something is to happen to a reply that is on its way, in time, and to no other. */
static bool is_sound_reply(const struct characters_reply *reply, dg_ns now)
{
    const bool on_the_way = reply->sent < reply->length;
    const bool timed = reply->next == reply->start || reply->next == reply->to;

    return reply->sent <= reply->length && reply->rest <= reply->pace.baud &&
           reply->start <= reply->from && reply->from <= reply->to &&
           reply->pace.rest <= reply->pace.baud && dg_elapsed(reply->to, reply->floor) <= 1u &&
           (on_the_way ? timed && reply->next >= now : reply->next == DG_NEVER);
}

void dg_bus_characters_pass_place(struct bus_place *base, struct bus_tape *tape)
{
    struct characters_place *place = (struct characters_place *)(void *)base;
    struct characters_place copy = *place;

    copy.place.deadline = dg_bus_tape_deadline(tape, base);
    dg_bus_tape_members(tape, place_rows, DG_COUNT(place_rows), place, &copy);
    dg_bus_tape_expect(tape,
                       is_sound_reply(&copy.reply, tape->now) && copy.kept == (copy.said > 0));
    if (tape->way == BUS_TAPE_RESTORE) {
        *place = copy;
    }
}
