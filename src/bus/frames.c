/* SPDX-License-Identifier: MIT */
/*
 * Frames between encoders and wire, and the states of the encoders' controllers:
 *
 *   encoder -- waits for its memory? -- faults, late? -- tap, encoders that listen -- pace? -->
 * wire wire, other encoders -- who listens? -- faults --> encoder
 *
 * An encoder must not be called back while it sends, so what encoders send each other waits until
 * it is through: then it is their turn, at the same moment.
 */
#include <string.h>

#include "drehgeber/wire_fault.h"
#include "frames_private.h"

/* Turns at one moment. Encoders that make each other send without end go on a nanosecond later. */
#define TURNS_MAX 16u
/* So much of what a late host has cost is made up for. */
#define CATCH_UP DG_MS(5)
#define DLC_MAX 8u

/* --- on the wire --- */

static bool is_free(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);

    return !wire->setup.pace || wire->busy_until <= self->now;
}

/* It begins at `begin`. */
static void transmit(struct dg_bus *self, size_t from, const struct dg_can_frame *frame,
                     dg_ns begin)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const uint32_t bits = DG_CAN_BITS(1u, dg_can_bytes(frame));
    const struct dg_tap_event event = {
        .at = self->now, .kind = DG_TAP_FRAME, .ours = true, .frame = *frame};

    wire->bits += bits;
    if (wire->setup.pace && wire->bit_rate != 0) {
        wire->busy_until = dg_after(begin, dg_bit_times_ns(bits, wire->bit_rate));
    }
    self->ops->tx(self->ctx, from, &event);
}

static bool others_listen(const struct dg_bus *self, size_t from, uint16_t id)
{
    struct frames_set set = dg_bus_filter_of(self, id);
    static const struct frames_set nobody = {{0}};

    set.word[from / 32u] &= ~(UINT32_C(1) << from % 32u);
    return memcmp(&set, &nobody, sizeof set) != 0;
}

/* Who looks sees it, and who listens has to hear it. */
static void tell_frame(struct dg_bus *self, size_t from, const struct dg_can_frame *frame)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const struct dg_tap_event event = {
        .at = self->now, .kind = DG_TAP_FRAME, .ours = true, .frame = *frame};

    dg_bus_tell(self, &event);
    if (wire->head[frame->id % FRAMES_IDS] != 0 && others_listen(self, from, frame->id)) {
        (void)dg_bus_room_add(wire, &wire->heard, from, self->now, frame);
    }
}

static void await_turn(struct dg_bus *self, size_t from, const struct dg_can_frame *frame)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    (void)dg_bus_room_add(wire, &wire->sending, from, self->now, frame);
    if (wire->setup.pace && wire->sending.count >= DG_BUS_FRAMES_PACED && !wire->full) {
        wire->full = true;
        wire->counters.stalls++;
    }
}

static void emit(struct dg_bus *self, size_t from, const struct dg_can_frame *frame)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);

    if (wire->setup.arbitrate) {
        await_turn(self, from, frame);
        return;
    }
    tell_frame(self, from, frame);
    if (is_free(self) && wire->sending.count == 0) {
        transmit(self, from, frame, self->now);
    } else {
        await_turn(self, from, frame);
    }
}

/* A frame that has waited follows the one before it at once, however late the host was, within
 * bounds. */
static void send_waiting(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const dg_ns earliest = dg_elapsed(self->now, CATCH_UP);

    while (wire->sending.count > 0 && is_free(self) && !wire->stalled) {
        const struct dg_bus_frames_room sent = wire->setup.arbitrate
                                                   ? dg_bus_room_arbitrate(wire, &wire->sending)
                                                   : dg_bus_room_fetch(wire, &wire->sending);
        dg_ns begin = wire->busy_until > sent.at ? wire->busy_until : sent.at;
        begin = begin > earliest ? begin : earliest;
        if (wire->setup.arbitrate) {
            tell_frame(self, sent.from, &sent.frame);
        }
        transmit(self, sent.from, &sent.frame, begin);
    }
    wire->full = wire->full && wire->sending.count > DG_BUS_FRAMES_PACED / 2u;
}

/* --- from an encoder --- */

/* Now, or behind those that are late already: an encoder's frames keep their order. */
static void send_in_time(struct frames_place *from, const struct dg_can_frame *frame, dg_ns delay)
{
    struct dg_bus *self = from->base.bus;
    struct frames_wire *wire = dg_bus_frames_wire(self);
    dg_ns at = dg_after(self->now, delay);

    if (delay == 0 && from->held == 0) {
        emit(self, from->base.index, frame);
        return;
    }
    if (from->held > 0 && at < from->last_held) {
        at = from->last_held;
    }
    if (dg_bus_room_add(wire, &wire->held, from->base.index, at, frame)) {
        from->held++;
        from->last_held = at;
        wire->release = dg_earliest(wire->release, at);
    }
}

/* Through the faults of its wire. */
static void send_frame(struct frames_place *from, const struct dg_can_frame *frame)
{
    struct dg_can_frame bent = *frame;
    struct dg_wire_sent sent = {.bytes = bent.data, .length = dg_can_bytes(frame), .times = 1};

    if (from->base.control != NULL) {
        dg_wire_fault_send(from->base.control, &sent);
    }
    for (unsigned i = 0; i < sent.times; i++) {
        send_in_time(from, &bent, sent.delay);
    }
}

static enum dg_bus_answer ask_memory(const struct frames_place *from)
{
    const struct dg_bus *self = from->base.bus;

    return self->ops->answer != NULL ? self->ops->answer(self->ctx, from->base.index) : DG_BUS_SAY;
}

/* Behind what the encoder has written, when that is durable. */
static void acknowledge(struct frames_place *from, const struct dg_can_frame *frame)
{
    struct dg_bus *self = from->base.bus;
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const enum dg_bus_answer what = from->answers.count > 0 ? DG_BUS_KEEP : ask_memory(from);

    if (what == DG_BUS_SAY) {
        send_frame(from, frame);
    } else if (what == DG_BUS_KEEP && from->answers.count == DG_BUS_FRAMES_ANSWERS) {
        wire->counters.lost++;
    } else if (what == DG_BUS_KEEP) {
        (void)dg_bus_room_add(wire, &from->answers, from->base.index, self->now, frame);
    }
}

/* What it listens to from now on, e.g. heartbeats of another one that it just was told of, may come
 * as soon as its answer is out. */
static void hear(struct bus_place *base, const struct dg_host_event *event)
{
    struct frames_place *from = (struct frames_place *)(void *)base;
    struct dg_can_frame frame = {.id = (uint16_t)event->id,
                                 .rtr = (event->flags & DG_HOST_REMOTE) != 0,
                                 .dlc = event->length};

    dg_bus_line_follow(from);
    dg_bus_filter_tell(base->bus);
    if (!from->hears || event->kind != DG_HOST_CAN) {
        return;
    }
    memcpy(frame.data, event->data, sizeof frame.data);
    if ((event->flags & DG_HOST_ACKNOWLEDGES) != 0) {
        acknowledge(from, &frame);
    } else {
        send_frame(from, &frame);
    }
}

static void release_held(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    dg_ns next = DG_NEVER;

    if (wire->release > self->now) {
        return;
    }
    for (uint16_t left = wire->held.count; left > 0; left--) {
        const struct dg_bus_frames_room late = dg_bus_room_fetch(wire, &wire->held);
        if (late.at <= self->now) {
            dg_bus_frames_at(self, late.from)->held--;
            emit(self, late.from, &late.frame);
        } else {
            (void)dg_bus_room_add(wire, &wire->held, late.from, late.at, &late.frame);
            next = dg_earliest(next, late.at);
        }
    }
    wire->release = next;
}

/* --- to an encoder --- */

static void note_deadline(struct frames_place *place, dg_ns due)
{
    struct frames_wire *wire = dg_bus_frames_wire(place->base.bus);

    wire->passed = wire->passed || (place->due <= wire->soonest && due > place->due);
    wire->soonest = dg_earliest(wire->soonest, due);
    place->due = due;
    dg_bus_line_follow(place);
}

/* Whoever had to wait is late: it does once what it has missed. */
static void feed_event(struct frames_place *place, const struct dg_host_event *event)
{
    dg_host_skip(place->base.host, place->base.bus->now);
    note_deadline(place, dg_host_feed(place->base.host, event));
}

static void tell_controller(struct frames_place *place, uint32_t what)
{
    const struct dg_host_event event = {
        .at = place->base.bus->now, .id = what, .kind = DG_HOST_BUS};

    feed_event(place, &event);
}

/* A frame that the controller had to drop is an event to the encoder. */
static void feed_frame(struct frames_place *place, const struct dg_host_event *event)
{
    struct dg_encoder *control = place->base.control;
    const enum dg_wire_heard heard = control != NULL ? dg_wire_fault_hear(control) : DG_WIRE_HEARD;

    if (heard == DG_WIRE_HEARD) {
        feed_event(place, event);
    } else if (heard == DG_WIRE_LOST) {
        tell_controller(place, DG_HOST_BUS_OVERRUN);
    }
}

/* To those that listen, but for `from`; DG_BUS_FRAMES_ENCODERS: the other end sent it. */
static void offer(struct dg_bus *self, const struct dg_can_frame *frame, size_t from)
{
    const struct frames_set set = dg_bus_filter_of(self, frame->id % FRAMES_IDS);
    struct dg_host_event event = {.at = self->now,
                                  .id = frame->id,
                                  .flags = frame->rtr ? DG_HOST_REMOTE : 0,
                                  .kind = DG_HOST_CAN,
                                  .length = frame->dlc};

    memcpy(event.data, frame->data, sizeof frame->data);
    for (size_t i = 0; i < DG_COUNT(set.word); i++) {
        uint32_t word = set.word[i];
        for (size_t place = 32u * i; word != 0; place++, word >>= 1) {
            if ((word & 1u) != 0 && place != from) {
                feed_frame(dg_bus_frames_at(self, place), &event);
            }
        }
    }
}

/* --- time --- */

/* What is sent meanwhile is for the next turn. */
static void hear_each_other(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    for (uint16_t left = wire->heard.count; left > 0; left--) {
        const struct dg_bus_frames_room heard = dg_bus_room_fetch(wire, &wire->heard);
        offer(self, &heard.frame, heard.from);
    }
}

static void find_soonest(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    wire->soonest = DG_NEVER;
    wire->passed = false;
    for (size_t i = 0; i < self->count; i++) {
        wire->soonest = dg_earliest(wire->soonest, dg_bus_frames_at(self, i)->due);
    }
}

static void step_encoders(struct dg_bus *self)
{
    if (dg_bus_frames_wire(self)->soonest > self->now) {
        return;
    }
    for (size_t i = 0; i < self->count; i++) {
        struct frames_place *place = dg_bus_frames_at(self, i);
        if (place->due <= self->now) {
            dg_host_skip(place->base.host, self->now);
            note_deadline(place, dg_host_step(place->base.host, self->now));
        }
    }
}

/* The encoders are asked what they know, as a power cycle may lie between two looks. */
static void tell_presence(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    wire->unsure = false;
    for (size_t i = 0; i < self->count; i++) {
        struct frames_place *place = dg_bus_frames_at(self, i);
        const void *device = dg_host_line_of(place->base.host)->device;
        const bool there = dg_bus_line_has_bus(wire, place);
        const bool knows_one = place->ask->is_news(device, DG_HOST_BUS_ABSENT);
        const bool sure = there && wire->setup.line.company == DG_BUS_SOMEBODY;
        if (there != knows_one || sure) {
            const enum dg_host_bus what = there ? DG_HOST_BUS_PRESENT : DG_HOST_BUS_ABSENT;
            if (place->ask->is_news(device, what)) {
                tell_controller(place, what);
            }
        }
    }
}

/* What is due, until nothing is. */
static void settle(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    do {
        if (wire->retuned) {
            dg_bus_line_tune(self);
        }
        step_encoders(self);
        if (wire->unsure && !wire->retuned) {
            tell_presence(self);
        }
    } while (wire->retuned);
}

bool dg_bus_frames_waits(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);

    return wire->stalled || wire->full;
}

static bool is_something_left(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);

    return !dg_bus_frames_waits(self) &&
           (wire->heard.count > 0 || (wire->sending.count > 0 && is_free(self)));
}

static void go_on(struct dg_bus *self, dg_ns now)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    unsigned turns = 0;

    if (wire->setup.real_time && self->called > now) {
        self->now = self->called;
    }
    release_held(self);
    do {
        send_waiting(self);
        if (!dg_bus_frames_waits(self)) {
            hear_each_other(self);
        }
        if (!dg_bus_frames_waits(self)) {
            settle(self);
        }
    } while (is_something_left(self) && ++turns < TURNS_MAX);
    if (wire->passed) {
        find_soonest(self);
    }
    dg_bus_filter_tell(self);
}

static dg_ns next(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);
    dg_ns next = wire->release;

    if (wire->sending.count > 0 && !wire->stalled) {
        next = dg_earliest(next, wire->setup.pace ? wire->busy_until : self->now);
    }
    if (!dg_bus_frames_waits(self)) {
        next = dg_earliest(next, wire->heard.count > 0 ? self->now : wire->soonest);
    }
    return next;
}

/* --- the other end --- */

/* One that has come in cannot have begun before the one before it was through. Of frames that come
   faster than the wire is, the present one counts, so that a flood does not add up to silence. */
static void count_bits(struct dg_bus *self, uint32_t bits)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    wire->bits += bits;
    if (!wire->setup.pace || wire->bit_rate == 0) {
        return;
    }
    const dg_ns longest = dg_bit_times_ns(DG_CAN_BITS(1u, DLC_MAX), wire->bit_rate);
    const dg_ns span = dg_bit_times_ns(bits, wire->bit_rate);
    if (wire->busy_until > dg_elapsed(self->now, span)) {
        const dg_ns latest = dg_after(self->now, longest + span);
        wire->busy_until = dg_earliest(dg_after(wire->busy_until, span), latest);
    }
}

static void take(struct dg_bus *self, const struct dg_tap_event *event)
{
    struct dg_tap_event seen = *event;

    if (event->kind != DG_TAP_FRAME || event->frame.dlc > DLC_MAX) {
        return;
    }
    seen.at = self->now;
    seen.ours = false;
    dg_bus_tell(self, &seen);
    count_bits(self, DG_CAN_BITS(1u, dg_can_bytes(&event->frame)));
    offer(self, &event->frame, DG_BUS_FRAMES_ENCODERS);
}

void dg_bus_frames_count(struct dg_bus *self, dg_ns now, uint32_t bits)
{
    dg_bus_look(self, now);
    count_bits(self, bits);
}

uint64_t dg_bus_frames_bits(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);
    const struct dg_bus_frames_ops *ops = wire->setup.ops;

    return ops != NULL && ops->bits != NULL ? ops->bits(self->ctx) : wire->bits;
}

const struct dg_bus_frames_counters *dg_bus_frames_counters(const struct dg_bus *self)
{
    return &dg_bus_frames_wire(self)->counters;
}

void dg_bus_frames_stall(struct dg_bus *self, bool stalled)
{
    dg_bus_frames_wire(self)->stalled = stalled;
}

/* The controller is what the wire's is, or the worse one that a fault makes. */
static void follow_controller(struct frames_place *place)
{
    const struct dg_encoder *control = place->base.control;
    const enum dg_controller own = dg_bus_frames_wire(place->base.bus)->state;

    tell_controller(place, control != NULL ? dg_fault_controller(&control->faults, own) : own);
}

dg_ns dg_bus_frames_controller(struct dg_bus *self, dg_ns now, enum dg_host_bus event)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const bool lost = event == DG_HOST_BUS_OVERRUN;

    dg_bus_look(self, now);
    if (!lost && wire->state == DG_CONTROLLER_OFF && event != DG_HOST_BUS_ACTIVE) {
        return dg_bus_step(self, now);
    }
    wire->state = lost ? wire->state : (enum dg_controller)event;
    for (size_t i = 0; i < self->count; i++) {
        struct frames_place *place = dg_bus_frames_at(self, i);
        if (place->hears && lost) {
            tell_controller(place, event);
        } else if (place->hears) {
            follow_controller(place);
        }
    }
    return dg_bus_step(self, now);
}

/* --- the medium --- */

static int begin(struct dg_bus *self, const void *setup)
{
    static const struct dg_bus_frames_setup usual = {.size = sizeof usual};
    struct frames_wire *wire = dg_bus_frames_wire(self);

    wire->setup = setup != NULL ? *(const struct dg_bus_frames_setup *)setup : usual;
    if (wire->setup.size != sizeof wire->setup || wire->setup.rooms >= UINT16_MAX ||
        (wire->setup.rooms > 0 && wire->setup.room == NULL)) {
        return DG_ERR_ARGUMENT;
    }
    wire->soonest = DG_NEVER;
    wire->release = DG_NEVER;
    wire->retuned = true;
    dg_bus_room_begin(wire);
    return DG_OK;
}

/* Its deadline is kept here: encoders wait when the wire has no room. */
static void keep_deadline(struct frames_place *place)
{
    const dg_ns due = place->base.deadline;

    place->base.deadline = DG_NEVER;
    note_deadline(place, due);
}

static int attach(struct bus_place *base)
{
    struct frames_place *place = (struct frames_place *)(void *)base;

    place->ask = dg_host_wire_at(base->host)->controller;
    if (place->ask == NULL) {
        return DG_ERR_ARGUMENT;
    }
    place->due = DG_NEVER;
    place->hears = true;
    place->version = ~place->ask->version(dg_host_line_of(base->host)->device);
    dg_bus_frames_wire(base->bus)->retuned = true;
    keep_deadline(place);
    return DG_OK;
}

/* Its bus before anything else. Without power nothing waits. */
static void feel(struct bus_place *base, dg_ns now)
{
    struct frames_place *place = (struct frames_place *)(void *)base;
    struct frames_wire *wire = dg_bus_frames_wire(base->bus);

    (void)now;
    while (!dg_host_powered(base->host) && place->answers.count > 0) {
        (void)dg_bus_room_fetch(wire, &place->answers);
    }
    follow_controller(place);
}

static void changed(struct bus_place *base, dg_ns now)
{
    (void)now;
    keep_deadline((struct frames_place *)(void *)base);
    dg_bus_frames_wire(base->bus)->unsure = true;
}

static void durable(struct bus_place *base, dg_ns now)
{
    struct frames_place *place = (struct frames_place *)(void *)base;
    struct frames_wire *wire = dg_bus_frames_wire(base->bus);
    const enum dg_bus_answer what = place->answers.count > 0 ? ask_memory(place) : DG_BUS_KEEP;

    (void)now;
    while (what != DG_BUS_KEEP && place->answers.count > 0) {
        const struct dg_bus_frames_room answer = dg_bus_room_fetch(wire, &place->answers);
        if (what == DG_BUS_SAY && place->hears) {
            send_frame(place, &answer.frame);
        }
    }
}

const struct dg_bus_medium dg_bus_frames = {
    .medium = DG_MEDIUM_FRAMES,
    .wire_size = sizeof(struct frames_wire),
    .place_size = sizeof(struct frames_place),
    .encoders_most = DG_BUS_FRAMES_ENCODERS,
    .keeps_deadlines = true,
    .begin = begin,
    .attach = attach,
    .hear = hear,
    .take = take,
    .go_on = go_on,
    .next = next,
    .feel = feel,
    .changed = changed,
    .durable = durable,
};
