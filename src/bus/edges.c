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
 * Handles are asked below their queues, by the operations of their wire: a lone healthy encoder
 * costs not much more than itself.
 */
#include "drehgeber/bus_edges.h"

#include "bus_private.h"
#include "drehgeber/line_fault.h"
#include "edges_cable.h"

/* The line. */
struct edges {
    struct dg_cable cable;
    dg_ns fell; /* the clock at the encoders' end, last */
    uint32_t there_ns;
    uint32_t period_ns; /* 0: as the clock's edges say */
    bool clock;         /* at the master's end */
    bool alone;         /* one encoder and no cable */
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

/* What is on the other side of its fault. `rises`: behind a rising edge of the clock, whose period
   is that then. */
static bool show_line(struct edges_place *self, bool rises, dg_ns period)
{
    const bool raw = self->live && self->wire->level(self->line);

    if (!self->fault.active) {
        return raw;
    }
    if (rises) {
        dg_line_fault_advance(&self->fault, raw, period);
    }
    return dg_line_fault_level(&self->fault, raw);
}

/* Each of `count` shows its neighbour its line, from the last to the first. @return what gets to
   the master */
static bool show_lines(const struct dg_bus *bus, size_t count, bool rises, dg_ns period)
{
    bool level = false;

    for (size_t i = count; i-- > 0;) {
        struct edges_place *place = edges_at(bus, i);
        place->line->behind = level;
        level = show_line(place, rises, period);
    }
    return level;
}

static void send_level(const struct dg_bus *bus, dg_ns at)
{
    dg_cable_put(&edges_of(bus)->cable, at, show_lines(bus, bus->count, false, 0));
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
    struct dg_cable_change change;

    while (dg_cable_take(&edges_of(bus)->cable, until, &change)) {
        tell_levels(bus, change.at, true);
    }
}

/* --- time --- */

static dg_ns first_deadline(const struct dg_bus *bus)
{
    dg_ns first = DG_NEVER;

    for (size_t i = 0; i < bus->count; i++) {
        first = dg_earliest(first, edges_at(bus, i)->place.deadline);
    }
    return first;
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
    dg_ns due = first_deadline(bus);

    while (due <= until && due != DG_NEVER) {
        for (size_t i = 0; i < bus->count; i++) {
            step_encoder(edges_at(bus, i), due);
        }
        send_level(bus, due);
        /* Whoever asks for the present again would stop time. */
        const dg_ns next = first_deadline(bus);
        due = next > due ? next : dg_after(due, 1);
    }
}

static dg_ns period_of(const struct edges *self, dg_ns at)
{
    return self->period_ns != 0 ? self->period_ns : 2u * dg_elapsed(at, self->fell);
}

static void take_edge(struct dg_bus *bus, bool level)
{
    struct edges *self = edges_of(bus);
    const dg_ns there = dg_after(bus->now, self->there_ns);
    const bool rises = level && !self->clock;
    const bool before = self->cable.level;
    struct dg_cable_change change;

    run_encoders(bus, there);
    for (size_t i = 0; i < bus->count; i++) {
        if (edges_at(bus, i)->live) {
            (void)clock_encoder(edges_at(bus, i), there, level);
        }
    }
    dg_cable_put(&self->cable, there, show_lines(bus, bus->count, rises, period_of(self, there)));
    self->fell = self->clock && !level ? there : self->fell;
    /* Without a cable the answer comes at once: one event for both. */
    while (dg_cable_take(&self->cable, bus->now, &change)) {
    }
    const bool clocked = self->clock != level;
    self->clock = level;
    if (clocked || self->cable.level != before) {
        tell_levels(bus, bus->now, self->cable.level != before);
    }
}

/* One encoder without a cable, which no fault happens to and which waits for nothing before that.
   @return false: nothing was done */
static bool take_short(struct dg_bus *bus, dg_ns now, bool level)
{
    struct edges *self = edges_of(bus);
    struct edges_place *only = edges_at(bus, 0);

    if (only->place.deadline <= now || now < bus->now || dg_line_fault_due(&only->fault)) {
        return false;
    }
    bus->now = now;
    const bool raw = clock_encoder(only, now, level);
    const bool data = only->fault.active ? dg_line_fault_level(&only->fault, raw) : raw;
    const bool changed = data != self->cable.level;
    const bool clocked = self->clock != level;
    dg_cable_pass(&self->cable, now, data);
    self->fell = self->clock && !level ? now : self->fell;
    self->clock = level;
    if (changed || (clocked && bus->ops->tap != NULL)) {
        tell_levels(bus, now, changed);
    }
    return true;
}

bool dg_bus_edge(struct dg_bus *bus, dg_ns now, bool level)
{
    const struct edges *self = edges_of(bus);
    const struct dg_tap_event event = {
        .at = now, .kind = DG_TAP_LEVELS, .levels = {level, self->cable.level}};

    if (!self->alone || !take_short(bus, now, level)) {
        (void)dg_bus_rx(bus, &event);
    }
    return self->cable.level;
}

/* --- looks --- */

bool dg_bus_edges_clock(const struct dg_bus *bus)
{
    return edges_of(bus)->clock;
}

bool dg_bus_edges_data(const struct dg_bus *bus, dg_ns at)
{
    return dg_cable_level(&edges_of(bus)->cable, at);
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
    dg_cable_init(&self->cable, wanted->back_ns, false);
    return DG_OK;
}

/* It may have got its power for the first time. */
static void look_alive(struct edges_place *self)
{
    struct dg_encoder *control = self->place.control;
    struct edges *edges = edges_of(self->place.bus);

    if (!self->live && dg_host_powered(self->place.host)) {
        self->live = true;
        if (control != NULL) {
            dg_line_fault_init(&self->fault, control->instrument, self->line->device,
                               &control->faults);
        }
    }
    edges->alone =
        self->live && self->place.bus->room == 1 && edges->there_ns == 0 && edges->cable.back == 0;
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
    dg_cable_init(&edges->cable, edges->cable.back, show_lines(bus, place->index + 1u, false, 0));
    return DG_OK;
}

/* The bus looks at lines itself. */
static void hear(struct bus_place *from, const struct dg_host_event *event)
{
    (void)from;
    (void)event;
}

static void take(struct dg_bus *bus, const struct dg_tap_event *event)
{
    if (event->kind == DG_TAP_LEVELS) {
        take_edge(bus, event->levels.clock);
    }
}

static void go_on(struct dg_bus *bus, dg_ns now)
{
    run_encoders(bus, now);
    let_arrive(bus, now);
}

static dg_ns next(const struct dg_bus *bus)
{
    const struct dg_cable *cable = &edges_of(bus)->cable;

    return cable->count != 0 ? cable->coming[cable->first].at : DG_NEVER;
}

static void changed(struct bus_place *place, dg_ns now)
{
    struct edges_place *self = (struct edges_place *)place;

    look_alive(self);
    settle_line(self);
    send_level(place->bus, now);
}

/* What was kept back was not sent, and the master asks again. */
static void durable(struct bus_place *place, dg_ns now)
{
    (void)place;
    (void)now;
}

const struct dg_bus_medium dg_bus_edges = {
    .medium = DG_MEDIUM_EDGES,
    .wire_size = sizeof(struct edges),
    .place_size = sizeof(struct edges_place),
    .encoders_most = DG_BUS_CHAIN_MAX,
    .begin = begin,
    .attach = attach,
    .hear = hear,
    .take = take,
    .go_on = go_on,
    .next = next,
    .changed = changed,
    .durable = durable,
};
