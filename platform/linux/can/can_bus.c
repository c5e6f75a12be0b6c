/* SPDX-License-Identifier: MIT */
/*
 * The core says what is next, this file makes it happen:
 *
 *   wire ---- on_frame -----> dg_co_net_rx() --\
 *   wire ---- on_bus -------> follow            > settle(): deadlines, filters, bit rates
 *   timer --- settle -------> dg_co_net_step() /
 *                                   \-- send_frame --> wire, other nodes in the next settle()
 *
 * A node whose bit rate is not the wire's lives on, but outside the net: deaf and mute. One without
 * power stays in it, listening to nothing.
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

/* --- what the nodes do to the wire --- */

/* Whoever looks at the wire wants to see what nobody on it listens to, too. */
static void tell_filters(struct lx_can_bus *self)
{
    const size_t size = sizeof self->filter_version;
    const bool tapped = lx_tap_on(&self->bus.tap);
    if (self->can->ops->filter == NULL ||
        (self->told && self->tapped == tapped &&
         memcmp(self->filter_version, self->net.filter_version, size) == 0)) {
        return;
    }
    memcpy(self->filter_version, self->net.filter_version, size);
    self->tapped = tapped;
    self->told = true;
    self->can->ops->filter(self->can, tapped ? NULL : &self->net);
}

/* What a node listens to from now on, e.g. heartbeats of another one that it just was told of, may
   come as soon as its answer is out. Of one that is not in the net yet nobody knows. */
static void let_in(struct lx_can_node *node)
{
    struct lx_can_bus *bus = node->bus;
    if (node->index != LX_CAN_DEAF) {
        bus->told = !dg_co_net_follow(&bus->net, node->index) && bus->told;
        tell_filters(bus);
    } else if (bus->can->ops->filter != NULL) {
        bus->told = false;
        bus->can->ops->filter(bus->can, NULL);
    }
}

static void send_frame(void *ctx, const struct dg_can_frame *frame)
{
    struct lx_can_node *node = ctx;
    if (!node->hears) {
        return;
    }
    let_in(node);
    lx_can_answer(node, frame);
}

static bool hears(const struct lx_can_node *node)
{
    const struct lx_can *can = node->bus->can;
    return can->ops->hears == NULL || can->ops->hears(can, node->kbaud);
}

/* The wire's own, or where it has none that of the slowest encoder that hears it; 0: unknown. */
static uint32_t bit_rate(const struct lx_can_bus *self)
{
    const struct lx_can_ops *ops = self->can->ops;
    const uint32_t own = ops->bit_rate == NULL ? 0 : ops->bit_rate(self->can);
    uint32_t kbaud = 0;
    for (size_t i = 0; own == 0 && i < self->bus.setup.count; i++) {
        const struct lx_can_node *node = &self->node[i];
        if (node->hears && node->kbaud != 0 && (kbaud == 0 || node->kbaud < kbaud)) {
            kbaud = node->kbaud;
        }
    }
    return own != 0 ? own : 1000u * kbaud;
}

static void keep_pace(struct lx_can_bus *self)
{
    self->can->pace = self->pace ? bit_rate(self) : 0;
}

/* Called inside the core: whether the node still hears is settled after that, but what it sends
   from here on already is at its new rate. */
static void use_bit_rate(void *ctx, uint16_t kbaud)
{
    struct lx_can_node *node = ctx;
    node->kbaud = kbaud;
    node->bus->can->ops->expect(node->bus->can, kbaud);
    node->bus->retuned = true;
    node->hears = hears(node);
    keep_pace(node->bus);
}

static const struct dg_co_ops node_ops = {.send = send_frame, .bit_rate = use_bit_rate};

/* --- what the wire and the time do to the nodes --- */

/* The net of those that hear the wire; on one that has no rate of its own, of all. */
static void tune(struct lx_can_bus *self)
{
    const size_t count = self->bus.setup.count;
    for (size_t i = 0; i < count; i++) {
        const bool now = hears(&self->node[i]);
        self->retuned = self->retuned || now != self->node[i].hears;
        self->node[i].hears = now;
    }
    keep_pace(self);
    if (!self->retuned) {
        return;
    }
    self->retuned = false;
    self->told = false;
    dg_co_net_init(&self->net);
    for (size_t i = 0; i < count; i++) {
        struct lx_can_node *node = &self->node[i];
        node->index = LX_CAN_DEAF;
        if (node->hears && dg_co_net_add(&self->net, &node->device.node) == DG_OK) {
            node->index = (uint8_t)(self->net.count - 1u);
        }
    }
}

/* What is due. @return the next deadline */
static dg_ns step(struct lx_can_bus *self, dg_ns now)
{
    dg_ns next = dg_co_net_step(&self->net, now);
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        if (!self->node[i].hears) {
            next = dg_earliest(next, dg_co_step(&self->node[i].device.node, now));
        }
    }
    return next;
}

/* Once per episode, that no real bus would carry this. */
static void measure(struct lx_can_bus *self, dg_ns now)
{
    if (!lx_can_load_due(&self->load, now)) {
        return;
    }
    const uint32_t rate = bit_rate(self);
    if (lx_can_load_take(&self->load, now, lx_can_bits(self->can), rate)) {
        lx_note(self->bus.setup.say,
                "%s: bus load %lu %% of %lu bit/s, more than a real bus carries%s",
                self->can->address, (unsigned long)(self->load.permille / 10u), (unsigned long)rate,
                self->pace ? "" : "; pace=1 spaces what the encoders send");
    }
}

/* After everything that happened to the nodes. While the wire is stalled nothing is due. */
static void settle(void *ctx, dg_ns now)
{
    struct lx_can_bus *self = ctx;
    const bool stalled = self->can->stalled;
    dg_ns next = DG_NEVER;
    lx_bus_serve(&self->bus, self->promised, now);
    if (!stalled) {
        lx_can_hear(self, now);
    }
    do {
        tune(self);
        next = self->can->stalled ? DG_NEVER : step(self, now);
    } while (self->retuned || lx_can_tell_presence(self, now));
    tell_filters(self);
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        lx_can_tell_shared(&self->node[i]);
    }
    if (self->can->ops->push != NULL) {
        self->can->ops->push(self->can);
    }
    if (self->can->stalled) {
        next = DG_NEVER;
    } else if (self->heard.count > 0) {
        next = now;
    }
    measure(self, now);
    self->promised = next;
    lx_timer_at(&self->timer, next);
}

static void on_frame(void *ctx, dg_ns now, const struct dg_can_frame *frame)
{
    struct lx_can_bus *self = ctx;
    lx_can_tell(self, now, false, frame);
    lx_can_count(self->can, LX_CAN_BITS(1u, lx_can_bytes(frame)));
    if (self->bent) {
        lx_can_offer(self, now, frame, NULL);
    } else {
        (void)dg_co_net_rx(&self->net, now, frame);
    }
}

/* A controller that is bus-off is so until it is active again. */
static void on_bus(void *ctx, dg_ns now, enum dg_co_bus_event event)
{
    struct lx_can_bus *self = ctx;
    if (event == DG_CO_BUS_OVERRUN) {
        (void)dg_co_net_bus(&self->net, now, event);
        return;
    }
    if (self->state == DG_CO_BUS_OFF && event != DG_CO_BUS_ACTIVE) {
        return;
    }
    self->state = event;
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        if (self->node[i].hears) {
            lx_can_follow(&self->node[i], now);
        }
    }
}

static void on_settled(void *ctx, dg_ns now)
{
    struct lx_can_node *node = ctx;
    lx_can_answer_settled(node);
    settle(node->bus, now);
}

static void release(void *ctx, dg_ns now)
{
    lx_can_release(ctx, now);
    settle(ctx, now);
}

/* --- the operations --- */

static int open_wire(struct lx_can_bus *self, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    const struct lx_can_setup can = {
        .event = setup->event,
        .silkit = setup->silkit,
        .say = setup->say,
        .where = setup->wire->where,
        .rx = on_frame,
        .bus = on_bus,
        .settle = settle,
        .ctx = self,
    };
    int result = lx_timer_open(&self->timer, setup->event, settle, self);
    if (result >= 0) {
        result = lx_timer_open(&self->release, setup->event, release, self);
    }
    if (result < 0) {
        return lx_fail(error, "no timer: %s", strerror(-result));
    }
    self->can = self->open(&can, error);
    return self->can == NULL ? -1 : 0;
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct lx_can_bus *self = can_bus_of(bus);
    if (open_wire(self, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < bus->setup.count; i++) {
        if (lx_can_node_open(&self->node[i], &node_ops, on_settled, now, error) != 0) {
            return -1;
        }
    }
    settle(self, now);
    lx_can_load_begin(&self->load, now, lx_can_bits(self->can));
    self->promised = DG_NEVER; /* the loop has not begun yet */
    return 0;
}

static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    const struct lx_can_bus *self = (const struct lx_can_bus *)bus;
    const struct lx_can_node *node = &self->node[station->place];
    (void)snprintf(to, size, "%s/%u", self->can->address, node->device.node.id);
}

static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct lx_can_bus *self = can_bus_of(bus);
    if (station != NULL) {
        self->bent = false;
        for (size_t i = 0; i < bus->setup.count; i++) {
            lx_can_bend(&self->node[i], now);
        }
    }
    settle(self, now);
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct lx_can_bus *self = (const struct lx_can_bus *)bus;
    const dg_ns now = lx_now();
    const uint64_t bits = lx_can_load_due(&self->load, now) ? lx_can_bits(self->can) : 0;
    const uint32_t load = lx_can_load_permille(&self->load, now, bits, bit_rate(self));
    const struct lx_count rows[] = {
        {"wire_up", self->can->ops->up(self->can)},       {"wire_late", bus->late + bus->stalls},
        {"wire_stalls", self->can->counters.stalls},      {"wire_lost", self->can->counters.lost},
        {"wire_kbaud", self->node[station->place].kbaud}, {"wire_load_permille", load},
    };
    lx_bus_count(to, rows, DG_COUNT(rows));
}

static void close_bus(struct lx_bus *bus)
{
    struct lx_can_bus *self = can_bus_of(bus);
    for (size_t i = 0; i < bus->setup.count; i++) {
        lx_can_node_close(&self->node[i]);
    }
    lx_can_close(self->can);
    lx_timer_close(&self->timer);
    lx_timer_close(&self->release);
    free(self->heard.frames);
    free(self->held.frames);
    free(self->node);
    free(self);
}

static const struct lx_bus_ops bus_ops = {LX_BUS_OPERATIONS};

/* --- making --- */

/* clang-format off */
static const struct dg_key keys[] = {
    {"pace", "", 0, DG_KEY_FLAG, 0, 1, 0, 1, dg_key_no_yes, "1: each frame takes its time at the bit rate"},
};
/* clang-format on */

const struct lx_keys lx_can_keys = {.rows = keys, .count = DG_COUNT(keys)};
const bool lx_can_pace = false;

struct lx_bus *lx_can_bus_make(const struct lx_bus_setup *setup, lx_can_open *open,
                               struct lx_error *error)
{
    struct lx_can_bus *self = calloc(1, sizeof *self);
    struct lx_can_node *node = calloc(setup->count, sizeof *node);
    if (self == NULL || node == NULL) {
        (void)lx_fail(error, "no memory for %lu encoders", (unsigned long)setup->count);
        free(node);
        free(self);
        return NULL;
    }
    self->bus.ops = &bus_ops;
    self->bus.setup = *setup;
    self->open = open;
    self->promised = DG_NEVER;
    self->node = node;
    self->pace = lx_can_pace;
    int result = 0;
    if (open != lx_silkit_can_open) { /* that has the keys of its simulation */
        result = lx_wire_settings(&lx_can_keys, setup->plan, setup->wire, &self->pace, error);
    }
    for (size_t i = 0; result == 0 && i < setup->count; i++) {
        result = lx_can_node_make(self, i, error);
    }
    if (result != 0) {
        free(node);
        free(self);
        return NULL;
    }
    return &self->bus;
}

struct lx_bus *lx_can_bus_make_socket(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return lx_can_bus_make(setup, lx_can_socket_open, error);
}

struct lx_bus *lx_can_bus_make_slcan(const struct lx_bus_setup *setup, struct lx_error *error)
{
    static const char tcp[] = "tcp:";
    const char *where = setup->wire->where;
    if (where == NULL || strncmp(where, tcp, strlen(tcp)) != 0) {
        return lx_can_bus_make(setup, lx_slcan_pty_open, error);
    }
    return lx_slcan_net_check(where, error) == 0 ? lx_can_bus_make(setup, lx_slcan_net_open, error)
                                                 : NULL;
}

struct lx_bus *lx_can_bus_make_socketcand(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return lx_socketcand_check(setup->wire->where, error) == 0
               ? lx_can_bus_make(setup, lx_socketcand_open, error)
               : NULL;
}

struct lx_bus *lx_can_bus_make_silkit(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return lx_can_bus_make(setup, lx_silkit_can_open, error);
}
