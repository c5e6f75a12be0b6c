/* SPDX-License-Identifier: MIT */
/*
 * Frames between encoders and wire, and the states of the encoders' controllers:
 *
 *   encoder --> its memory? --> faults, late? --> tap, others that listen --> pace? --> wire
 *   encoder <-- faults <-- who listens? <-- wire, other encoders
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
static void transmit_frame(struct dg_bus *self, size_t from, const struct dg_tap_event *event,
                           dg_ns begin)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const uint32_t bits = DG_CAN_BITS(1u, dg_can_bytes(&event->frame));

    wire->bits += bits;
    if (wire->setup.pace && wire->bit_rate != 0) {
        wire->busy_until = dg_after(begin, dg_bit_times_ns(bits, wire->bit_rate));
    }
    self->ops->tx(self->ctx, from, event);
}

static bool others_listen(const struct dg_bus *self, size_t from, uint16_t id)
{
    struct frames_set set = dg_bus_filter_of(self, id);
    static const struct frames_set nobody = {{0}};

    set.word[from / 32u] &= ~(UINT32_C(1) << from % 32u);
    return memcmp(&set, &nobody, sizeof set) != 0;
}

/* Who looks sees it, and who listens has to hear it. */
static void tell_frame(struct dg_bus *self, size_t from, const struct dg_tap_event *event)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const uint16_t id = event->frame.id;

    dg_bus_tell(self, event);
    if (wire->head[id % FRAMES_IDS] != 0 && others_listen(self, from, id)) {
        (void)dg_bus_room_add(wire, &wire->heard, from, self->now, &event->frame);
    }
}

static struct dg_tap_event event_of(const struct dg_bus *self, const struct dg_can_frame *frame)
{
    return (struct dg_tap_event){
        .at = self->now, .kind = DG_TAP_FRAME, .ours = true, .frame = *frame};
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

static void emit_event(struct dg_bus *self, size_t from, const struct dg_tap_event *event)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);

    if (wire->setup.arbitrate) {
        await_turn(self, from, &event->frame);
        return;
    }
    tell_frame(self, from, event);
    if (is_free(self) && wire->sending.count == 0) {
        transmit_frame(self, from, event, self->now);
    } else {
        await_turn(self, from, &event->frame);
    }
}

static void emit_frame(struct dg_bus *self, size_t from, const struct dg_can_frame *frame)
{
    const struct dg_tap_event event = event_of(self, frame);

    emit_event(self, from, &event);
}

static void fetch_waiting(struct frames_wire *wire, struct dg_bus_frames_room *sent)
{
    *sent = wire->setup.arbitrate ? dg_bus_room_arbitrate(wire, &wire->sending)
                                  : dg_bus_room_fetch(wire, &wire->sending);
}

/* A frame that has waited follows the one before it at once, however late the host was, within
 * bounds. */
static void send_waiting(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const dg_ns earliest = dg_elapsed(self->now, CATCH_UP);

    while (wire->sending.count > 0 && is_free(self) && !wire->stalled) {
        struct dg_bus_frames_room sent;
        fetch_waiting(wire, &sent);
        dg_ns begin = wire->busy_until > sent.at ? wire->busy_until : sent.at;
        begin = begin > earliest ? begin : earliest;
        const struct dg_tap_event event = event_of(self, &sent.frame);
        if (wire->setup.arbitrate) {
            tell_frame(self, sent.from, &event);
        }
        transmit_frame(self, sent.from, &event, begin);
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
        emit_frame(self, from->base.index, frame);
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

static void send_bent(struct frames_place *from, const struct dg_can_frame *frame)
{
    struct dg_can_frame bent = *frame;
    struct dg_wire_sent sent = DG_WIRE_UNBENT;

    if (from->base.control != NULL) {
        sent = dg_wire_fault_send(from->base.control, dg_can_bytes(frame));
    }
    if (sent.damaged != DG_WIRE_WHOLE) {
        bent.data[sent.damaged] ^= sent.flip;
    }
    for (unsigned i = 0; i < sent.times; i++) {
        send_in_time(from, &bent, sent.delay);
    }
}

static bool is_frame_bent(const struct frames_place *place)
{
    const struct dg_encoder *control = place->base.control;

    return place->held > 0 || (control != NULL && control->faults.wire != 0);
}

/* Through the faults of its wire. */
static void send_event(struct frames_place *from, const struct dg_tap_event *event)
{
    if (is_frame_bent(from)) {
        send_bent(from, &event->frame);
    } else {
        emit_event(from->base.bus, from->base.index, event);
    }
}

static enum dg_bus_answer ask_memory(const struct frames_place *from)
{
    const struct dg_bus *self = from->base.bus;

    return self->ops->answer != NULL ? self->ops->answer(self->ctx, from->base.index) : DG_BUS_SAY;
}

/* Behind what the encoder has written, when that is durable. */
static void acknowledge_frame(struct frames_place *from, const struct dg_tap_event *event)
{
    struct dg_bus *self = from->base.bus;
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const enum dg_bus_answer what = from->answers.count > 0 ? DG_BUS_KEEP : ask_memory(from);

    if (what == DG_BUS_SAY) {
        send_event(from, event);
    } else if (what == DG_BUS_KEEP && from->answers.count == DG_BUS_FRAMES_ANSWERS) {
        wire->counters.lost++;
    } else if (what == DG_BUS_KEEP) {
        (void)dg_bus_room_add(wire, &from->answers, from->base.index, self->now, &event->frame);
    }
}

/* What the encoder tells of itself may have changed. */
static void refresh_filters(struct frames_place *place)
{
    const uint32_t version = place->ask->version(place->device);

    if (version != place->version) {
        dg_bus_line_follow(place, version);
    }
}

/* What it listens to from now on, e.g. heartbeats of another one that it just was told of, may come
 * as soon as its answer is out. */
static void hear_frame(struct bus_place *base, const struct dg_host_event *event)
{
    struct frames_place *from = (struct frames_place *)(void *)base;
    struct dg_tap_event sent = {.at = base->bus->now,
                                .kind = DG_TAP_FRAME,
                                .ours = true,
                                .frame = {.id = (uint16_t)event->id,
                                          .rtr = (event->flags & DG_HOST_REMOTE) != 0,
                                          .dlc = event->length}};

    refresh_filters(from);
    if (dg_bus_frames_wire(base->bus)->refiltered) {
        dg_bus_filter_tell(base->bus);
    }
    if (!from->hears || event->kind != DG_HOST_CAN) {
        return;
    }
    memcpy(sent.frame.data, event->data, sizeof sent.frame.data);
    if (from->ask->acknowledges(from->device, event->id)) {
        acknowledge_frame(from, &sent);
    } else {
        send_event(from, &sent);
    }
}

static void release_held(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    dg_ns next = DG_NEVER;

    for (uint16_t left = wire->held.count; left > 0; left--) {
        const struct dg_bus_frames_room late = dg_bus_room_fetch(wire, &wire->held);
        if (late.at <= self->now) {
            dg_bus_frames_at(self, late.from)->held--;
            emit_frame(self, late.from, &late.frame);
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
    refresh_filters(place);
}

/* Whoever had to wait is late: it does once what it has missed. */
static void feed_event(struct frames_place *place, const struct dg_host_event *event)
{
    if (place->due < place->base.bus->now) {
        dg_host_skip(place->base.host, place->base.bus->now);
    }
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

static void feed_all(struct dg_bus *self, const struct dg_host_event *event, size_t from)
{
    const struct frames_set set = dg_bus_filter_of(self, (uint16_t)event->id);

    for (size_t i = 0; i < DG_COUNT(set.word); i++) {
        uint32_t word = set.word[i];
        for (size_t place = 32u * i; word != 0; place++, word >>= 1) {
            if ((word & 1u) != 0 && place != from) {
                feed_frame(dg_bus_frames_at(self, place), event);
            }
        }
    }
}

/* To those that listen, but for `from`; DG_BUS_FRAMES_ENCODERS: the other end sent it. Most frames
 * are for one encoder. */
static void offer_frame(struct dg_bus *self, const struct dg_can_frame *frame, size_t from)
{
    const uint16_t id = frame->id % FRAMES_IDS;
    const size_t filter = dg_bus_frames_wire(self)->head[id];
    struct dg_host_event event = {.at = self->now,
                                  .id = id,
                                  .flags = frame->rtr ? DG_HOST_REMOTE : 0,
                                  .kind = DG_HOST_CAN,
                                  .length = frame->dlc};

    if (filter == 0) {
        return;
    }
    memcpy(event.data, frame->data, sizeof frame->data);
    const size_t place = (filter - 1u) / DG_HOST_FILTERS;
    struct frames_place *first = dg_bus_frames_at(self, place);
    if (first->filter[(filter - 1u) % DG_HOST_FILTERS].next != 0) {
        feed_all(self, &event, from);
    } else if (place != from) {
        feed_frame(first, &event);
    }
}

/* --- time --- */

/* What is sent meanwhile is for the next turn. */
static void hear_each_other(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    for (uint16_t left = wire->heard.count; left > 0; left--) {
        const struct dg_bus_frames_room heard = dg_bus_room_fetch(wire, &wire->heard);
        offer_frame(self, &heard.frame, heard.from);
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

static void step_frame_encoders(struct dg_bus *self)
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

/* The encoder is asked what it knows, as a power cycle may lie between two looks. */
void dg_bus_frames_tell_presence(struct frames_place *place)
{
    const struct frames_wire *wire = dg_bus_frames_wire(place->base.bus);
    const bool there = dg_bus_line_has_bus(wire, place);
    const bool knows_one = place->ask->is_news(place->device, DG_HOST_BUS_ABSENT);
    const bool sure = there && wire->setup.line.company == DG_BUS_SOMEBODY;
    const enum dg_host_bus what = there ? DG_HOST_BUS_PRESENT : DG_HOST_BUS_ABSENT;

    if ((there != knows_one || sure) && place->ask->is_news(place->device, what)) {
        tell_controller(place, what);
    }
}

static void tell_presence(struct dg_bus *self)
{
    dg_bus_frames_wire(self)->unsure = false;
    for (size_t i = 0; i < self->count; i++) {
        dg_bus_frames_tell_presence(dg_bus_frames_at(self, i));
    }
}

/* What is due, until nothing is. */
static void settle_encoders(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    do {
        if (wire->retuned) {
            dg_bus_line_tune(self);
        }
        step_frame_encoders(self);
        if (wire->unsure && !wire->retuned) {
            tell_presence(self);
        }
    } while (wire->retuned);
}

static inline bool waits(const struct frames_wire *wire)
{
    return wire->stalled || wire->full;
}

bool dg_bus_frames_waits(const struct dg_bus *self)
{
    return waits(dg_bus_frames_wire(self));
}

static bool is_something_left(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);

    return !waits(wire) && (wire->heard.count > 0 || (wire->sending.count > 0 && is_free(self)));
}

static void go_on(struct dg_bus *self, dg_ns now)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    unsigned turns = 0;

    if (wire->setup.real_time && self->called > now) {
        self->now = self->called;
    }
    if (wire->release <= self->now) {
        release_held(self);
    }
    do {
        if (wire->sending.count > 0) {
            send_waiting(self);
        }
        if (!waits(wire)) {
            hear_each_other(self);
        }
        if (!waits(wire)) {
            settle_encoders(self);
        }
    } while (is_something_left(self) && ++turns < TURNS_MAX);
    if (wire->passed) {
        find_soonest(self);
    }
    if (wire->refiltered) {
        dg_bus_filter_tell(self);
    }
}

static dg_ns next(const struct dg_bus *self)
{
    const struct frames_wire *wire = dg_bus_frames_wire(self);
    dg_ns next = wire->release;

    if (wire->sending.count > 0 && !wire->stalled) {
        next = dg_earliest(next, wire->setup.pace ? wire->busy_until : self->now);
    }
    if (!waits(wire)) {
        const bool now = wire->heard.count > 0 || wire->retuned;
        next = dg_earliest(next, now ? self->now : wire->soonest);
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

static void tell_other_end(const struct dg_bus *self, const struct dg_tap_event *event)
{
    if (event->at == self->now && !event->ours) {
        dg_bus_tell(self, event);
    } else {
        struct dg_tap_event seen = *event;
        seen.at = self->now;
        seen.ours = false;
        dg_bus_tell(self, &seen);
    }
}

static void take_frame(struct dg_bus *self, const struct dg_tap_event *event)
{
    if (event->kind != DG_TAP_FRAME || event->frame.dlc > DLC_MAX) {
        return;
    }
    if (dg_bus_frames_wire(self)->retuned) {
        dg_bus_line_tune(self);
    }
    tell_other_end(self, event);
    count_bits(self, DG_CAN_BITS(1u, dg_can_bytes(&event->frame)));
    offer_frame(self, &event->frame, DG_BUS_FRAMES_ENCODERS);
}

void dg_bus_frames_count(struct dg_bus *self, dg_ns now, uint32_t bits)
{
    dg_bus_look(self, now);
    count_bits(self, bits);
}

uint64_t dg_bus_frames_bits(const struct dg_bus *self)
{
    return dg_bus_frames_wire(self)->bits;
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

    place->ask = dg_host_side_at(base->host)->controller;
    if (place->ask == NULL) {
        return DG_ERR_ARGUMENT;
    }
    place->device = dg_host_line_of(base->host)->device;
    place->due = DG_NEVER;
    place->hears = true;
    place->version = ~place->ask->version(place->device);
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
    struct frames_place *place = (struct frames_place *)(void *)base;

    (void)now;
    /* A state that was restored may be one of another encoder, and its version the same. */
    place->version = ~place->ask->version(place->device);
    keep_deadline(place);
    dg_bus_frames_tell_presence(place);
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
            const struct dg_tap_event event = event_of(base->bus, &answer.frame);
            send_event(place, &event);
        }
    }
}

const struct dg_bus_medium dg_bus_frames = {
    .medium = DG_MEDIUM_FRAMES,
    .wire_size = sizeof(struct frames_wire),
    .place_size = sizeof(struct frames_place),
    .encoders_most = DG_BUS_FRAMES_ENCODERS,
    .begin = begin,
    .attach = attach,
    .hear = hear_frame,
    .take = take_frame,
    .go_on = go_on,
    .next = next,
    .feel = feel,
    .changed = changed,
    .durable = durable,
    .pass_wire = dg_bus_frames_pass_wire,
    .pass_place = dg_bus_frames_pass_place,
    .restored = dg_bus_frames_restored,
    .detach = dg_bus_frames_detach,
    .moved = dg_bus_frames_moved,
};
