/* SPDX-License-Identifier: MIT */
/*
 * A reply of an encoder, from the handle to its last stop bit:
 *
 *   dg_bus_reply_add .. dg_bus_reply_begin --[durable? else kept]--> start_reply --[faults]--\
 *                                                                                          |
 *   go_on (bus_characters.c) --> dg_bus_reply_go_on --> emit, with what others send <-------/
 *
 * Time of a character = its bits at the data rate, always counted from the start of the reply:
 *
 *   start   end of 0    end of 1    end of 2
 *     |40---------|43---------|03---------|        late once is late once
 *
 * An end is a sum of whole ns and of a rest, as a line is drawn on a screen: only the sum is
 * rounded up, and nothing is divided.
 */
#include "characters_private.h"

#include <string.h>

#include "drehgeber/wire_fault.h"

/* How a reply gets out. */
enum form {
    FORM_CHARACTERS, /* a character at a time, each at the end of its stop bit */
    FORM_WHOLE,      /* at its beginning, somebody else does the timing */
    FORM_AT_ONCE,    /* at its beginning, and it takes no time */
};

static enum form form_of(const struct characters_place *self)
{
    if (characters_line_of(self->place.bus)->setup.whole != NULL) {
        return FORM_WHOLE;
    }
    return self->end.at_once ? FORM_AT_ONCE : FORM_CHARACTERS;
}

/* --- time --- */

/* The present character is the next one. */
static void advance_reply(struct characters_reply *reply)
{
    const uint32_t room = reply->pace.baud - reply->rest;
    const bool carry = reply->pace.rest >= room;

    reply->rest = carry ? reply->pace.rest - room : reply->rest + reply->pace.rest;
    reply->floor = dg_after(reply->floor, reply->pace.whole + (carry ? 1u : 0u));
    reply->from = reply->to;
    reply->to = dg_after(reply->floor, reply->rest > 0 ? 1u : 0u);
}

static void rewind_to(struct characters_reply *reply, dg_ns start)
{
    reply->start = start;
    reply->to = start;
    reply->floor = start;
    reply->rest = 0;
    reply->sent = 0;
    reply->begun = false;
    advance_reply(reply);
}

static bool on_the_way(const struct characters_reply *reply)
{
    return reply->sent < reply->length;
}

/* Also before its start, when it is late (fault). */
static bool has_reply(const struct characters_place *self)
{
    return on_the_way(&self->reply) && form_of(self) != FORM_AT_ONCE;
}

bool dg_bus_reply_sends(const struct characters_place *self, dg_ns now)
{
    return has_reply(self) && now > self->reply.start;
}

bool dg_bus_reply_is_busy(const struct characters_place *self)
{
    return self->kept || has_reply(self);
}

static bool waits_for_all(const struct characters_place *self)
{
    return !self->reply.begun && form_of(self) != FORM_CHARACTERS;
}

/* Behind whatever changes it. */
static void set_next(struct characters_place *self)
{
    struct characters_reply *reply = &self->reply;

    if (!on_the_way(reply)) {
        reply->next = DG_NEVER;
    } else {
        reply->next = waits_for_all(self) ? reply->start : reply->to;
    }
}

/* --- begin --- */

static void forget_said(struct characters_place *self)
{
    self->said = 0;
    self->kept = false;
}

/* What was still on its way is cut off, but not by one that a fault has dropped. */
static void start_reply(struct characters_place *self, dg_ns at)
{
    struct characters_reply *reply = &self->reply;
    struct dg_wire_sent sent = DG_WIRE_UNBENT;

    if (self->place.control != NULL) {
        sent = dg_wire_fault_send(self->place.control, self->said);
    }
    if (sent.times > 0) {
        memcpy(reply->bytes, self->saying, self->said);
        reply->length = self->said;
        reply->merged = false;
        reply->damaged = CHARACTERS_WHOLE;
        reply->again = sent.times > 1;
        reply->pace = self->pace;
        rewind_to(reply, dg_after(at, sent.delay));
        set_next(self);
    }
    if (sent.damaged != DG_WIRE_WHOLE) { /* what is dropped is whole */
        reply->damaged = (uint8_t)sent.damaged;
        reply->bytes[sent.damaged] ^= sent.flip;
    }
    forget_said(self);
}

void dg_bus_reply_add(struct characters_place *self, const uint8_t *bytes, size_t n)
{
    if (self->kept) {
        forget_said(self);
    }
    const size_t room = sizeof self->saying - self->said;
    const size_t fits = n < room ? n : room;

    memcpy(self->saying + self->said, bytes, fits);
    self->said = (uint8_t)(self->said + fits);
}

static enum dg_bus_answer ask_port(const struct characters_place *self)
{
    const struct dg_bus *bus = self->place.bus;

    return bus->ops->answer != NULL ? bus->ops->answer(bus->ctx, self->place.index) : DG_BUS_SAY;
}

static dg_ns moment_of(const struct characters_place *self, dg_ns at)
{
    const struct dg_bus *bus = self->place.bus;

    return characters_line_of(bus)->setup.live && bus->called > at ? bus->called : at;
}

/* What is lost is not acknowledged. */
static void answer_or_keep(struct characters_place *self, dg_ns at)
{
    const enum dg_bus_answer answer = ask_port(self);

    self->kept = answer == DG_BUS_KEEP;
    if (answer == DG_BUS_SAY) {
        start_reply(self, at);
    } else if (answer == DG_BUS_DROP) {
        forget_said(self);
    }
}

void dg_bus_reply_begin(struct characters_place *self, dg_ns at)
{
    if (self->said > 0 && !self->kept) {
        answer_or_keep(self, moment_of(self, at));
    }
}

void dg_bus_reply_release(struct characters_place *self, dg_ns at)
{
    if (self->kept) {
        answer_or_keep(self, at);
    }
}

void dg_bus_reply_stop(struct characters_place *self)
{
    forget_said(self);
    self->reply.length = 0;
    self->reply.sent = 0;
    self->reply.again = false;
    self->reply.next = DG_NEVER;
}

/* --- go on --- */

/* The character that began before `at` and is not over yet. */
static bool has_character(const struct characters_place *self, dg_ns at)
{
    return on_the_way(&self->reply) && at > self->reply.from;
}

/* `byte` of `from` with what others send at the same time. @return whether anybody does */
static bool merge_byte(const struct characters_place *from, dg_ns at, uint8_t *byte, bool swallow)
{
    const struct dg_bus *bus = from->place.bus;
    bool met = false;

    for (size_t i = 0; i < bus->count; i++) {
        struct characters_place *other = characters_place_at(bus, i);
        if (other != from && has_character(other, at)) {
            *byte &= other->reply.bytes[other->reply.sent];
            other->reply.merged = other->reply.merged || swallow;
            met = true;
        }
    }
    return met;
}

static void tell_other_end(const struct characters_place *self, dg_ns at, uint8_t byte,
                           bool damaged)
{
    const struct dg_bus *bus = self->place.bus;
    struct dg_tap_event event = {
        .at = at,
        .kind = DG_TAP_CHARACTER,
        .ours = true,
        .character = {DG_BAUD_ANY, 0, byte, damaged},
    };

    if (!self->end.any_line) {
        event.character.baud = self->pace.baud;
        event.character.parity = self->pace.parity;
    }
    bus->ops->tx(bus->ctx, self->place.index, &event);
}

/* The present character is over: the other end hears it, unless it was told already, and everybody
 * else. */
static void emit_characters(struct characters_place *self, dg_ns at)
{
    struct characters_reply *reply = &self->reply;
    uint8_t byte = reply->bytes[reply->sent];
    bool damaged = reply->damaged == reply->sent;
    const bool merged = reply->merged;

    reply->merged = false;
    if (!merged) {
        damaged = merge_byte(self, at, &byte, true) || damaged;
    }
    reply->sent++;
    advance_reply(reply);
    if (merged) {
        return;
    }
    if (form_of(self) != FORM_WHOLE) {
        tell_other_end(self, at, byte, damaged);
    }
    dg_bus_spread(self, at, byte, damaged);
}

/* What is sent at the same time was told already: the later reply follows it, damaged. */
static void tell_whole(const struct characters_place *self)
{
    const struct characters_reply *reply = &self->reply;
    const struct dg_bus *bus = self->place.bus;
    uint8_t bytes[DG_REPLY_MAX];

    for (size_t i = 0; i < reply->length; i++) {
        bytes[i] = reply->bytes[i];
        (void)merge_byte(self, reply->start, &bytes[i], false);
    }
    characters_line_of(bus)->setup.whole(bus->ctx, self->place.index, reply->start, bytes,
                                         reply->length);
}

static void begin_at_once(struct characters_place *self)
{
    const dg_ns at = self->reply.start;

    self->reply.begun = true;
    if (form_of(self) == FORM_WHOLE) {
        tell_whole(self);
        return;
    }
    while (self->reply.sent < self->reply.length) {
        emit_characters(self, at);
    }
}

void dg_bus_reply_go_on(struct characters_place *self, dg_ns at)
{
    struct characters_reply *reply = &self->reply;

    if (waits_for_all(self)) {
        begin_at_once(self);
    } else {
        emit_characters(self, at);
    }
    if (reply->again && reply->sent == reply->length) {
        reply->again = false;
        rewind_to(reply, reply->from);
    }
    set_next(self);
}
