/* SPDX-License-Identifier: MIT */
/*
 * The bus in the library says what is next, this file makes it happen:
 *
 *   wire ---- on_frame -----> dg_bus_rx()
 *   wire ---- on_bus -------> dg_bus_frames_controller()   behind each of them settle_bus()
 *   timer --- settle_bus ---> dg_bus_step()
 *                                  \-- send_frame --> wire
 *
 * Who comes late does what is due at the moment he comes: no frame has begun before.
 */
#define _GNU_SOURCE
#include "can_bus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct lx_can_bus *can_bus_of(struct lx_bus *bus)
{
    return (struct lx_can_bus *)bus;
}

/* --- what the encoders do to the wire --- */

/* Whoever looks at the wire wants to see what nobody on it listens to, too. */
static void tell_filters(struct lx_can_bus *self)
{
    const bool tapped = lx_tap_on(&self->bus.tap);
    if (self->can->ops->filter == NULL || (self->told && self->tapped == tapped)) {
        return;
    }
    self->tapped = tapped;
    self->told = true;
    self->can->ops->filter(self->can, tapped ? NULL : self->bus.core);
}

static void refilter(void *ctx)
{
    struct lx_can_bus *self = ctx;
    self->told = false;
    tell_filters(self);
}

/* In the order of time: a frame that waited while another was answered is told after the answer. */
static void tell_tap(void *ctx, const struct dg_tap_event *event)
{
    struct lx_can_bus *self = ctx;
    if (!lx_tap_on(&self->bus.tap)) {
        return;
    }
    struct dg_tap_event told = *event;
    told.at = event->ours ? lx_now() : event->at;
    self->tapped_at = told.at > self->tapped_at ? told.at : self->tapped_at;
    told.at = self->tapped_at;
    lx_tap_tell(&self->bus.tap, &told);
}

static void send_frame(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct lx_can_bus *self = ctx;
    (void)place;
    lx_can_send(self->can, &event->frame);
    dg_bus_frames_stall(self->bus.core, self->can->stalled);
}

static enum dg_bus_answer answer(void *ctx, size_t place)
{
    struct lx_can_bus *self = ctx;
    return lx_nvm_queue_answer(&self->bus.setup.stations[place]->image.queue);
}

/* --- what the wire is --- */

/* @return whether it is another one */
static bool update_line(struct lx_can_bus *self)
{
    const struct lx_can *can = self->can;
    const struct lx_can_ops *ops = can->ops;
    const struct dg_bus_frames_line line = {
        .bit_rate = ops->bit_rate == NULL ? 0 : ops->bit_rate(can),
        .tolerant = ops->open == NULL,
        .closed = ops->open != NULL && !ops->open(can),
        .company = lx_can_is_up(can) ? can->company : DG_BUS_NOBODY,
    };
    dg_bus_frames_stall(self->bus.core, can->stalled);
    return dg_bus_frames_set_line(self->bus.core, &line);
}

static void retune(void *ctx, size_t place, uint32_t bit_rate)
{
    struct lx_can_bus *self = ctx;
    (void)place;
    self->can->ops->expect(self->can, (uint16_t)(bit_rate / 1000u));
    (void)update_line(self);
}

static uint64_t bits(const struct lx_can_bus *self)
{
    const struct lx_can_ops *ops = self->can->ops;
    return ops->bits == NULL ? dg_bus_frames_bits(self->bus.core) : ops->bits(self->can);
}

static bool paces(const struct lx_can_bus *self)
{
    return dg_engine_wire_of(self->bus.setup.engine, self->bus.setup.index)->frames.pace;
}

/* Once per episode, that no real bus would carry this. */
static void note_overload(struct lx_can_bus *self, dg_ns now)
{
    if (!dg_bus_load_due(&self->load, now)) {
        return;
    }
    const uint32_t rate = dg_bus_frames_bit_rate(self->bus.core);
    if (dg_bus_load_close(&self->load, now, bits(self), rate)) {
        lx_note(self->bus.setup.say,
                "%s: bus load %lu %% of %lu bit/s, more than a real bus carries%s",
                self->can->address, (unsigned long)(self->load.permille / 10u), (unsigned long)rate,
                paces(self) ? "" : "; pace=1 spaces what the encoders send");
    }
}

/* --- what the wire and the time do to the encoders --- */

/* After everything that happened to them. What waits for the wire's pace is not late. */
static void arm_timer(struct lx_can_bus *self, dg_ns now)
{
    tell_filters(self);
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        lx_can_tell_shared(&self->node[i]);
    }
    if (self->can->ops->push != NULL) {
        self->can->ops->push(self->can);
    }
    if (self->can->stalled) {
        self->stalled = true;
        dg_bus_frames_stall(self->bus.core, true);
        self->due = dg_bus_next(self->bus.core);
    }
    const bool waits = dg_bus_frames_waits(self->bus.core);
    lx_can_crowd(self->can, waits);
    note_overload(self, now);
    self->promised = waits ? DG_NEVER : self->due;
    lx_timer_at(&self->timer, self->due);
}

static void settle_bus(void *ctx, dg_ns now)
{
    struct lx_can_bus *self = ctx;
    lx_bus_serve(&self->bus, self->promised, now);
    const bool stalled = self->stalled;
    self->stalled = self->can->stalled;
    if (update_line(self) || self->due <= now || stalled) {
        self->due = dg_bus_step(self->bus.core, now);
    }
    arm_timer(self, now);
}

static void on_frame(void *ctx, dg_ns now, const struct dg_can_frame *frame)
{
    struct lx_can_bus *self = ctx;
    const struct dg_tap_event event = {.at = now, .kind = DG_TAP_FRAME, .frame = *frame};
    note_overload(self, now); /* an idle wire has called nobody when its window was over */
    self->due = dg_bus_rx(self->bus.core, &event);
    lx_can_crowd(self->can, dg_bus_frames_waits(self->bus.core));
}

static void on_foreign(void *ctx, uint32_t count)
{
    struct lx_can_bus *self = ctx;
    note_overload(self, lx_now());
    dg_bus_frames_count(self->bus.core, lx_now(), count);
}

static void on_bus(void *ctx, dg_ns now, enum dg_host_bus event)
{
    struct lx_can_bus *self = ctx;
    self->due = dg_bus_frames_controller(self->bus.core, now, event);
}

static void on_settled(void *ctx, dg_ns now)
{
    struct lx_can_node *node = ctx;
    struct lx_can_bus *self = node->bus;
    self->due = dg_bus_durable(self->bus.core, node->station->place, now);
    arm_timer(self, now);
}

/* --- the operations --- */

static int open_wire(struct lx_can_bus *self, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    const struct lx_can_setup can = {
        .event = setup->event,
        .silkit = setup->silkit,
        .timer = &self->timer,
        .tap = &self->bus.tap,
        .say = setup->say,
        .where = setup->wire->where,
        .rx = on_frame,
        .foreign = on_foreign,
        .bus = on_bus,
        .settle = settle_bus,
        .ctx = self,
    };
    if (lx_timer_make(&self->timer, setup->event, settle_bus, self, error) != 0) {
        return -1;
    }
    self->can = setup->door->open_can(&can, error);
    return self->can == NULL ? -1 : 0;
}

/* Encoders of a bus most often have one shaft. */
static size_t count_same(const struct lx_bus_setup *setup)
{
    size_t same = 1;
    while (same < setup->count &&
           setup->stations[same]->control->shaft == setup->stations[0]->control->shaft) {
        same++;
    }
    return same;
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct lx_can_bus *self = can_bus_of(bus);
    if (open_wire(self, error) != 0) {
        return -1;
    }
    (void)update_line(self);
    self->same = count_same(&bus->setup);
    for (size_t i = 0; i < bus->setup.count; i++) {
        if (lx_can_node_open(&self->node[i], on_settled, now, error) != 0) {
            return -1;
        }
    }
    for (size_t i = 0; i < bus->setup.count; i++) {
        self->due = dg_bus_changed(self->bus.core, i, now);
    }
    settle_bus(self, now);
    dg_bus_load_begin(&self->load, now, bits(self));
    self->promised = DG_NEVER; /* the loop has not begun yet */
    return 0;
}

static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    const struct lx_can_bus *self = (const struct lx_can_bus *)bus;
    const unsigned id = (unsigned)lx_can_node_id(&self->node[station->place]);
    (void)snprintf(to, size, "%s/%u", self->can->address, id);
}

static void look_at_bus(struct lx_bus *bus, dg_ns now)
{
    struct lx_can_bus *self = can_bus_of(bus);
    dg_bus_look(self->bus.core, now);
}

/* How calm the shafts of its encoders are, all together. A command makes one shaft and those that it
 * drives more calm, or less: then the sum is less. */
static unsigned count_calm(const struct lx_can_bus *self, dg_ns now)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    unsigned sum = 0;
    for (size_t i = 0; i < setup->count; i = i == 0 ? self->same : i + 1u) {
        sum += (unsigned)dg_world_calm(setup->stations[i]->control->world, now);
    }
    return sum;
}

static void turn_shaft(struct lx_bus *bus, dg_ns now)
{
    struct lx_can_bus *self = can_bus_of(bus);
    look_at_bus(bus, now);
    const unsigned calm = count_calm(self, now);
    self->calm = calm > self->calm ? calm : self->calm;
}

/* Encoders that sleep have not looked since. */
static void wake_encoders(struct lx_can_bus *self, dg_ns now)
{
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        self->due = dg_bus_changed(self->bus.core, i, now);
    }
}

static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct lx_can_bus *self = can_bus_of(bus);
    if (station != NULL) {
        (void)update_line(self);
        self->due = dg_bus_changed(self->bus.core, station->place, now);
    } else if (self->calm > count_calm(self, now)) {
        wake_encoders(self, now);
    }
    self->calm = station != NULL ? self->calm : 0;
    settle_bus(self, now);
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct lx_can_bus *self = (const struct lx_can_bus *)bus;
    const struct lx_can *can = self->can;
    const struct dg_bus_frames_counters *wire = dg_bus_frames_counters(self->bus.core);
    const struct lx_can_node *node = &self->node[station->place];
    const dg_ns now = lx_now();
    const uint32_t rate = dg_bus_frames_bit_rate(self->bus.core);
    const uint64_t so_far = dg_bus_load_due(&self->load, now) ? bits(self) : 0;
    dg_state_number(to, "wire_up", lx_can_is_up(can));
    dg_state_number(to, "wire_late", bus->late + bus->stalls);
    dg_state_number(to, "wire_stalls", can->counters.stalls + wire->stalls);
    dg_state_number(to, "wire_lost", can->counters.lost + wire->lost);
    dg_state_number(to, "wire_kbaud", lx_can_node_kbaud(node));
    dg_state_number(to, "wire_load_permille", dg_bus_load_permille(&self->load, now, so_far, rate));
}

static void close_bus(struct lx_bus *bus)
{
    struct lx_can_bus *self = can_bus_of(bus);
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        lx_station_close(self->bus.setup.stations[i]);
    }
    lx_can_close(self->can);
    lx_timer_close(&self->timer);
    free(self);
}

static const struct lx_bus_ops bus_ops = {LX_BUS_OPERATIONS, .look = look_at_bus,
                                          .turns = turn_shaft};

/* --- making --- */

static const struct dg_bus_ops door = {.tx = send_frame, .tap = tell_tap, .answer = answer};
static const struct dg_bus_frames_ops frames_door = {.filter = refilter, .retuned = retune};

struct lx_bus *lx_can_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                               struct lx_error *error)
{
    struct lx_can_bus *self =
        lx_bus_allocate(sizeof *self + setup->count * sizeof self->node[0], &bus_ops, setup, error);
    if (self == NULL) {
        return NULL;
    }
    self->promised = DG_NEVER;
    for (size_t i = 0; i < setup->count; i++) {
        lx_can_node_make(self, i);
    }
    to->ops = &door;
    to->ctx = self;
    to->frames.ops = &frames_door;
    to->frames.real_time = true;
    return &self->bus;
}
