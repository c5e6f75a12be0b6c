/* SPDX-License-Identifier: MIT */
/*
 * Clocked lines: a master clocks, encoders shift, each shows its line to the one in front of it.
 *
 *            fault 0              fault 1
 *   master <--(bends)-- encoder 0 <--(bends)-- encoder 1 ... <-- low
 *
 * A fault sits behind the encoder's driver: the encoder itself works, its neighbour, or the master,
 * sees something else.
 *
 * An edge of the clock is taken at the encoders' end at once, with the time at which it gets there;
 * what it does to data is then on its way back. All encoders see the same edge: what counts of a
 * neighbour is its level before it.
 *
 * Handles are asked below their queues, by the operations of their wire: an edge costs not much
 * more than the encoders do.
 */
#include "drehgeber/bus_edges.h"

#include "bus_private.h"
#include "bus_tape.h"
#include "drehgeber/line_fault.h"
#include "edges_cable.h"

/* The line. */
struct edges {
    struct dg_bus_cable cable;
    dg_ns due;  /* the first deadline of its encoders */
    dg_ns fell; /* the clock at the encoders' end, last */
    uint32_t there_ns;
    uint32_t period_ns; /* 0: as the clock's edges say */
    bool clock;         /* at the master's end */
};

/* An encoder on it. */
struct edges_place {
    struct bus_place place;
    const struct dg_host_wire *wire;
    struct dg_host_line *line;
    struct dg_line_fault fault;
    bool live; /* it was switched on once: there is a device */
};

static struct edges *edges_of(const struct dg_bus *bus)
{
    return bus->wire;
}

static struct edges_place *edges_at(const struct dg_bus *bus, size_t index)
{
    return (struct edges_place *)dg_bus_place_at(bus, index);
}

/* --- encoders --- */

/* Which faults happen to a frame is known when it begins. What an encoder sends in it may
   acknowledge a write of the frame before. */
static void begin_frame(struct edges_place *self)
{
    const struct dg_bus *bus = self->place.bus;

    dg_line_fault_begin(&self->fault);
    if (bus->ops->answer != NULL && bus->ops->answer(bus->ctx, self->place.index) != DG_BUS_SAY) {
        dg_line_fault_kill(&self->fault);
    }
}

/* The clock gets to it. @return its line */
static inline bool clock_encoder(struct edges_place *self, dg_ns at, bool level)
{
    struct dg_host_line *line = self->line;
    const dg_ns latched = line->latched;

    line->now = at;
    const bool data = self->wire->clock(line, at, level);
    self->place.deadline = self->wire->stack->step(line->device, at);
    if (line->latched != latched) {
        begin_frame(self);
    }
    return data;
}

/* One that waits for nothing has no frame on its line, and faults may have come or gone. */
static void settle_line(struct edges_place *self)
{
    if (dg_line_fault_due(&self->fault) && self->place.deadline == DG_NEVER) {
        dg_line_fault_end(&self->fault);
    }
}

static dg_ns period_of(const struct edges *self, dg_ns at)
{
    return self->period_ns != 0 ? self->period_ns : 2u * dg_elapsed(at, self->fell);
}

/* What is on the other side of its fault. `rises`: behind a rising edge of the clock, whose period
   is that then. */
static bool bend_level(struct edges_place *self, bool raw, bool rises, dg_ns period)
{
    if (rises) {
        dg_line_fault_advance(&self->fault, raw, period);
    }
    return dg_line_fault_level(&self->fault, raw);
}

/* Each of `count` shows its neighbour its line, from the last to the first. @return what gets to
   the master */
static bool show_lines(const struct dg_bus *bus, size_t count)
{
    bool level = false;

    for (size_t i = count; i-- > 0;) {
        struct edges_place *place = edges_at(bus, i);
        place->line->behind = level;
        level = place->live && place->wire->level(place->line);
        level = place->fault.active ? bend_level(place, level, false, 0) : level;
    }
    return level;
}

/* The edge gets to all of them, from the last to the first: each hears of its neighbour's new level
   when it has taken the edge itself. @return what gets to the master */
static bool clock_lines(const struct dg_bus *bus, dg_ns at, bool high, bool rises)
{
    struct edges *self = edges_of(bus);
    dg_ns due = DG_NEVER;
    bool level = false;

    for (size_t i = bus->count; i-- > 0;) {
        struct edges_place *place = edges_at(bus, i);
        bool own = place->live && clock_encoder(place, at, high);
        due = dg_earliest(due, place->place.deadline);
        if (place->line->behind != level) {
            place->line->behind = level;
            own = place->live && place->wire->level(place->line);
        }
        level = place->fault.active ? bend_level(place, own, rises, period_of(self, at)) : own;
    }
    self->due = due;
    return level;
}

static void send_level(const struct dg_bus *bus, dg_ns at)
{
    dg_bus_cable_put(&edges_of(bus)->cable, at, show_lines(bus, bus->count));
}

/* --- the master's end --- */

/* Clock and data from `at` on. */
static void tell_levels(const struct dg_bus *bus, dg_ns at, bool data_changed)
{
    const struct edges *self = edges_of(bus);
    const struct dg_tap_event event = {.at = at,
                                       .kind = DG_TAP_LEVELS,
                                       .ours = data_changed,
                                       .levels = {self->clock, self->cable.level}};

    dg_bus_tell(bus, &event);
    if (data_changed) {
        bus->ops->tx(bus->ctx, 0, &event);
    }
}

/* What gets to the master up to `until`. */
static void let_arrive(const struct dg_bus *bus, dg_ns until)
{
    struct dg_bus_cable_change change;

    while (dg_bus_cable_take(&edges_of(bus)->cable, until, &change)) {
        tell_levels(bus, change.at, true);
    }
}

/* --- time --- */

static void look_for_deadline(const struct dg_bus *bus, size_t count)
{
    dg_ns due = DG_NEVER;

    for (size_t i = 0; i < count; i++) {
        due = dg_earliest(due, edges_at(bus, i)->place.deadline);
    }
    edges_of(bus)->due = due;
}

static void step_encoder(struct edges_place *self, dg_ns at)
{
    if (self->place.deadline <= at) {
        self->line->now = at > self->line->now ? at : self->line->now;
        self->place.deadline = self->wire->stack->step(self->line->device, at);
        settle_line(self);
    }
}

/* Deadlines at the encoders' end up to `until`, each at its moment. */
static void run_encoders(const struct dg_bus *bus, dg_ns until)
{
    struct edges *self = edges_of(bus);

    while (self->due <= until && self->due != DG_NEVER) {
        const dg_ns at = self->due;
        for (size_t i = 0; i < bus->count; i++) {
            step_encoder(edges_at(bus, i), at);
        }
        send_level(bus, at);
        look_for_deadline(bus, bus->count);
        /* Whoever asks for the present again would stop time. */
        self->due = self->due > at ? self->due : dg_after(at, 1);
    }
}

/* Nothing is due before. Without a cable the answer comes at once: one event for both. */
static void take_bus_edge(const struct dg_bus *bus, bool level)
{
    struct edges *self = edges_of(bus);
    const dg_ns there = dg_after(bus->now, self->there_ns);
    const bool clocked = self->clock != level;
    const bool before = self->cable.level;
    struct dg_bus_cable_change change;

    const bool data = clock_lines(bus, there, level, clocked && level);
    if (data != self->cable.sent) {
        dg_bus_cable_put(&self->cable, there, data);
    }
    while (self->cable.count != 0 && dg_bus_cable_take(&self->cable, bus->now, &change)) {
    }
    self->fell = clocked && !level ? there : self->fell;
    self->clock = level;
    const bool answered = self->cable.level != before;
    if (answered || (clocked && bus->watched)) {
        tell_levels(bus, bus->now, answered);
    }
}

/* What is due before the edge gets there comes first. */
static void rx_edge(struct dg_bus *bus, dg_ns now, bool level)
{
    const struct dg_tap_event event = {
        .at = now, .kind = DG_TAP_LEVELS, .levels = {level, edges_of(bus)->cable.level}};

    (void)dg_bus_rx(bus, &event);
}

bool dg_bus_edge(struct dg_bus *bus, dg_ns now, bool level)
{
    const struct edges *self = edges_of(bus);

    if (now < bus->now || self->due <= dg_after(now, self->there_ns)) {
        rx_edge(bus, now, level);
        return self->cable.level;
    }
    if (self->cable.count != 0) {
        let_arrive(bus, dg_elapsed(now, 1));
    }
    bus->now = now;
    take_bus_edge(bus, level);
    return self->cable.level;
}

/* --- looks --- */

bool dg_bus_edges_clock(const struct dg_bus *bus)
{
    return edges_of(bus)->clock;
}

bool dg_bus_edges_data(const struct dg_bus *bus, dg_ns at)
{
    return dg_bus_cable_level(&edges_of(bus)->cable, at);
}

dg_ns dg_bus_edges_fell(const struct dg_bus *bus)
{
    return edges_of(bus)->cable.fell;
}

const char *dg_bus_edges_hint(struct dg_bus *bus, dg_ns now, dg_ns *due)
{
    const char *text = NULL;

    *due = DG_NEVER;
    for (size_t i = 0; i < bus->count; i++) {
        dg_ns again = DG_NEVER;
        const char *own = dg_host_hint(edges_at(bus, i)->place.host, now, &again);
        text = text != NULL ? text : own;
        *due = dg_earliest(*due, again);
    }
    return text;
}

/* --- the medium --- */

static int begin(struct dg_bus *bus, const void *setup)
{
    static const struct dg_bus_edges_setup usual = {.size = sizeof usual};
    const struct dg_bus_edges_setup *wanted = setup != NULL ? setup : &usual;
    struct edges *self = edges_of(bus);

    if (wanted->size != sizeof *wanted || wanted->there_ns > DG_BUS_CABLE_MAX_NS ||
        wanted->back_ns > DG_BUS_CABLE_MAX_NS) {
        return DG_ERR_ARGUMENT;
    }
    self->there_ns = wanted->there_ns;
    self->period_ns = wanted->period_ns;
    self->clock = true;
    self->due = DG_NEVER;
    dg_bus_cable_init(&self->cable, wanted->back_ns, false);
    return DG_OK;
}

/* It may have got its power for the first time, or a state of one that never had any, or its
   control plane. */
static void look_alive(struct edges_place *self)
{
    struct dg_encoder *control = self->place.control;
    struct dg_faults *faults = control != NULL ? &control->faults : NULL;
    const bool before = self->live;

    self->live = dg_host_made(self->place.host);
    if (!self->live) {
        self->place.deadline = DG_NEVER;
    } else if ((!before || faults != self->fault.faults) && control != NULL &&
               control->instrument->line_frame != NULL) {
        dg_line_fault_init(&self->fault, control->instrument, self->line->device, faults);
    }
}

/* Nobody knows what is connected before it is: the level is on all of the cable at once. */
static int attach(struct bus_place *place)
{
    struct edges_place *self = (struct edges_place *)place;
    const struct dg_bus *bus = place->bus;
    struct edges *edges = edges_of(bus);

    self->wire = dg_host_wire_at(place->host);
    self->line = dg_host_line_of(place->host);
    if (place->index > 0) {
        const struct edges_place *before = edges_at(bus, place->index - 1u);
        if (before->wire != self->wire || !self->wire->chains) {
            return DG_ERR_ARGUMENT;
        }
        before->line->chained = true;
    }
    self->fault.frame.open = true;
    look_alive(self);
    look_for_deadline(bus, place->index + 1u);
    dg_bus_cable_init(&edges->cable, edges->cable.back, show_lines(bus, place->index + 1u));
    return DG_OK;
}

/* The bus looks at lines itself. */
static void hear_level(struct bus_place *from, const struct dg_host_event *event)
{
    (void)from;
    (void)event;
}

static void take_clock(struct dg_bus *bus, const struct dg_tap_event *event)
{
    if (event->kind == DG_TAP_LEVELS) {
        run_encoders(bus, dg_after(bus->now, edges_of(bus)->there_ns));
        take_bus_edge(bus, event->levels.clock);
    }
}

static void go_on(struct dg_bus *bus, dg_ns now)
{
    run_encoders(bus, now);
    let_arrive(bus, now);
}

static dg_ns next(const struct dg_bus *bus)
{
    const struct edges *self = edges_of(bus);
    const struct dg_bus_cable *cable = &self->cable;

    return cable->count != 0 ? dg_earliest(cable->coming[cable->first].at, self->due) : self->due;
}

static void changed(struct bus_place *place, dg_ns now)
{
    struct edges_place *self = (struct edges_place *)place;

    look_alive(self);
    settle_line(self);
    look_for_deadline(place->bus, place->bus->count);
    send_level(place->bus, now);
}

/* --- states --- */

static const struct bus_member line_rows[] = {
    BUS_ANY(edges, fell),        BUS_BOOL(edges, clock),       BUS_ANY(edges, cable.fell),
    BUS_BOOL(edges, cable.sent), BUS_BOOL(edges, cable.level),
};

static const struct bus_member fault_rows[] = {
    BUS_BOOL(dg_line_fault, active),
    BUS_BOOL(dg_line_fault, cut),
    BUS_BOOL(dg_line_fault, started),
    BUS_BOOL(dg_line_fault, late),
    BUS_MEMBER(dg_line_fault, delay, DG_LINE_FAULT_DELAY_MAX),
    BUS_ANY(dg_line_fault, flip),
    BUS_ANY(dg_line_fault, bit),
    BUS_ANY(dg_line_fault, clocks),
    BUS_ANY(dg_line_fault, held),
};

/* Changes arrive one behind the other. */
static void pass_wire(const struct dg_bus *bus, struct bus_tape *tape)
{
    struct edges *self = edges_of(bus);
    struct dg_bus_cable *cable = &self->cable;
    const bool restores = tape->way == BUS_TAPE_RESTORE;
    const size_t count = dg_bus_tape_length(tape, cable->count, DG_BUS_CABLE_CHANGES);
    dg_ns latest = tape->now;

    for (size_t i = 0; i < count; i++) {
        const size_t at = restores ? i : (cable->first + i) % DG_BUS_CABLE_CHANGES;
        struct dg_bus_cable_change change = cable->coming[at];
        change.at = dg_bus_tape_moment(tape, change.at);
        change.level = dg_bus_tape_length(tape, change.level, 1) != 0;
        dg_bus_tape_expect(tape, change.at >= latest);
        latest = change.at;
        if (restores) {
            cable->coming[i] = change;
        }
    }
    dg_bus_tape_members(tape, line_rows, DG_COUNT(line_rows), self, dg_bus_tape_into(tape, self));
    if (restores) {
        cable->first = 0;
        cable->count = (uint16_t)count;
    }
}

/* The fault of the frame at hand, whatever faults are at work by now. */
static void pass_place(struct bus_place *place, struct bus_tape *tape)
{
    struct edges_place *self = (struct edges_place *)place;
    const dg_ns deadline = dg_bus_tape_moment(tape, place->deadline);

    dg_bus_tape_expect(tape, deadline >= tape->now);
    if (tape->way == BUS_TAPE_RESTORE) {
        place->deadline = deadline;
        look_alive(self);
    }
    dg_bus_tape_members(tape, fault_rows, DG_COUNT(fault_rows), &self->fault,
                        dg_bus_tape_into(tape, &self->fault));
}

static void restored(struct dg_bus *bus)
{
    look_for_deadline(bus, bus->count);
}

/* --- an encoder leaves --- */

static void detach(struct bus_place *place)
{
    const struct edges_place *self = (const struct edges_place *)place;

    self->line->behind = false;
    self->line->chained = false;
}

/* The last one has nobody behind it. */
static void moved(struct dg_bus *bus, size_t from)
{
    (void)from;
    if (bus->count > 0) {
        edges_at(bus, bus->count - 1u)->line->chained = false;
    }
    look_for_deadline(bus, bus->count);
    send_level(bus, bus->now);
}

const struct dg_bus_medium dg_bus_edges = {
    .medium = DG_MEDIUM_EDGES,
    .wire_size = sizeof(struct edges),
    .place_size = sizeof(struct edges_place),
    .encoders_most = DG_BUS_CHAIN_MAX,
    .begin = begin,
    .attach = attach,
    .hear = hear_level,
    .take = take_clock,
    .go_on = go_on,
    .next = next,
    .changed = changed,
    .pass_wire = pass_wire,
    .pass_place = pass_place,
    .restored = restored,
    .detach = detach,
    .moved = moved,
};
