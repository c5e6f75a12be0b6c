/* SPDX-License-Identifier: MIT */
/*
 * Frames between the nodes of a bus and its wire, and what faults make of them:
 *
 *   node -- bus-off? drop? damage? -- held back? -- emit --> tap, wire, nodes that listen
 *                            duplicate? --/
 *   wire, other nodes -- bus-off? deaf? overrun? --> node
 *
 * The core must not be called back while it sends, so what nodes send each other waits until it is
 * through. The net's deadlines are kept here as dg_co_net_rx() keeps them.
 */
#include "can_bus.h"

#include <string.h>

static struct dg_faults *faults_of(const struct lx_can_node *node)
{
    return &node->station->control.faults;
}

/* --- from a node --- */

/* Whether a node of the net other than `from` listens to this CAN-ID: seldom, as encoders consume
   nothing of each other but heartbeats. */
static bool others_listen(const struct lx_can_node *from, uint16_t id)
{
    const struct dg_co_net *net = &from->bus->net;
    uint8_t listeners[sizeof net->listeners[0]];
    static const uint8_t nobody[sizeof listeners];
    memcpy(listeners, net->listeners[id], sizeof listeners);
    if (from->index != LX_CAN_DEAF) {
        listeners[from->index / 8u] &= (uint8_t) ~(1u << from->index % 8u);
    }
    return memcmp(listeners, nobody, sizeof listeners) != 0;
}

void lx_can_tell(struct lx_can_bus *self, dg_ns at, bool ours, const struct dg_can_frame *frame)
{
    if (!lx_tap_on(&self->bus.tap)) {
        return;
    }
    self->tapped_at = at > self->tapped_at ? at : self->tapped_at;
    const struct lx_tap_event event = {
        .at = self->tapped_at, .kind = LX_TAP_FRAME, .ours = ours, .frame = *frame};
    lx_tap_tell(&self->bus.tap, &event);
}

void lx_can_emit(struct lx_can_node *from, const struct dg_can_frame *frame)
{
    struct lx_can_bus *self = from->bus;
    lx_can_tell(self, lx_now(), true, frame);
    lx_can_send(self->can, frame);
    if (others_listen(from, frame->id)) {
        const struct lx_can_waiting waiting = {.from = from, .frame = *frame};
        (void)lx_can_list_append(&self->heard, &waiting);
    }
}

/* Now, or behind the ones that are held back already: a node's frames keep their order. */
static void send_in_time(struct lx_can_node *from, const struct dg_can_frame *frame)
{
    struct lx_can_bus *self = from->bus;
    struct lx_can_waiting waiting = {.from = from, .at = lx_now(), .frame = *frame};
    const bool delayed = dg_fault_wire_takes(faults_of(from), DG_WIRE_DELAY);
    if (!delayed && from->held == 0) {
        lx_can_emit(from, frame);
        return;
    }
    if (delayed) {
        waiting.at =
            dg_after(waiting.at, (dg_ns)dg_fault_wire_value(&dg_cia406_stack, DG_WIRE_DELAY));
    }
    if (from->held > 0 && waiting.at < from->last_held) {
        waiting.at = from->last_held;
    }
    if (!lx_can_list_append(&self->held, &waiting)) {
        return;
    }
    from->held++;
    from->last_held = waiting.at;
    lx_timer_at(&self->release, dg_earliest(self->release.at, waiting.at));
}

void lx_can_emit_bent(struct lx_can_node *from, const struct dg_can_frame *frame)
{
    struct dg_faults *faults = faults_of(from);
    struct dg_can_frame sent = *frame;
    if (dg_fault_wire_active(faults, DG_WIRE_BUS_OFF) ||
        dg_fault_wire_takes(faults, DG_WIRE_DROP)) {
        return;
    }
    /* Without data there is no bit to flip. */
    if (sent.dlc > 0 && dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
        const uint32_t bit = dg_fault_pick(faults, 8u * sent.dlc);
        sent.data[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    }
    const unsigned times = dg_fault_wire_takes(faults, DG_WIRE_DUPLICATE) ? 2 : 1;
    for (unsigned i = 0; i < times; i++) {
        send_in_time(from, &sent);
    }
}

void lx_can_release(struct lx_can_bus *self, dg_ns now)
{
    struct lx_can_list *held = &self->held;
    dg_ns next = DG_NEVER;
    size_t left = 0;
    for (size_t i = 0; i < held->count; i++) {
        const struct lx_can_waiting *waiting = &held->frames[i];
        if (waiting->at <= now) {
            waiting->from->held--;
            lx_can_emit(waiting->from, &waiting->frame);
        } else {
            next = dg_earliest(next, waiting->at);
            held->frames[left++] = *waiting;
        }
    }
    held->count = left;
    lx_timer_at(&self->release, next);
}

/* --- to a node --- */

/* What the core has answered to a call that did not go through the net. */
static void note_deadline(struct lx_can_node *node, dg_ns deadline)
{
    if (node->index != LX_CAN_DEAF) {
        node->bus->net.deadline[node->index] = deadline;
    }
}

/* A frame that the controller had to drop is an event to the node. */
static bool overruns(struct lx_can_node *node, dg_ns now)
{
    const bool lost = dg_fault_wire_takes(faults_of(node), DG_WIRE_OVERRUN);
    if (lost) {
        note_deadline(node, dg_co_bus(&node->device, now, DG_CO_BUS_OVERRUN));
    }
    return lost;
}

static bool reaches(struct lx_can_node *node, dg_ns now)
{
    struct dg_faults *faults = faults_of(node);
    return faults->wire == 0 ||
           (!dg_fault_wire_active(faults, DG_WIRE_BUS_OFF) &&
            !dg_fault_wire_takes(faults, DG_WIRE_DEAF) && !overruns(node, now));
}

void lx_can_offer(struct lx_can_bus *self, dg_ns now, const struct dg_can_frame *frame,
                  const struct lx_can_node *from)
{
    for (uint8_t i = 0; i < self->net.count; i++) {
        struct lx_can_node *node = self->net.node[i]->setup.ctx;
        const bool listens = ((unsigned)self->net.listeners[frame->id][i / 8u] >> i % 8u & 1u) != 0;
        if (listens && node != from && reaches(node, now)) {
            note_deadline(node, dg_co_rx(&node->device, now, frame));
        }
    }
}

void lx_can_hear(struct lx_can_bus *self, dg_ns now)
{
    /* What is sent meanwhile is for the next turn: appending may move the list, too. */
    const size_t count = self->heard.count;
    for (size_t i = 0; i < count; i++) {
        const struct lx_can_waiting heard = self->heard.frames[i];
        lx_can_offer(self, now, &heard.frame, heard.from);
    }
    self->heard.count -= count;
    if (self->heard.count > 0) {
        memmove(self->heard.frames, self->heard.frames + count,
                self->heard.count * sizeof *self->heard.frames);
    }
}

/* --- the controller --- */

/* What the node believes: the core is asked, as a power cycle may lie between two looks. */
static enum dg_co_bus_event state_of(const struct dg_co_node *device)
{
    if (device->bus_off) {
        return DG_CO_BUS_OFF;
    }
    return (device->active_causes >> DG_CO_CAUSE_PASSIVE & 1u) != 0 ? DG_CO_BUS_PASSIVE
                                                                    : DG_CO_BUS_ACTIVE;
}

static bool has_bus(const struct lx_can_node *node)
{
    const struct lx_can *can = node->bus->can;
    return node->hears && can->ops->up(can) && can->company != LX_CAN_NOBODY;
}

/* The core is asked what it knows, as above. */
bool lx_can_tell_presence(struct lx_can_bus *self, dg_ns now)
{
    bool told = false;
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        struct lx_can_node *node = &self->node[i];
        const struct dg_co_node *device = &node->device;
        const bool there = has_bus(node);
        const bool sure = there && self->can->company == LX_CAN_SOMEBODY;
        if (there == device->bus_absent ||
            (sure && !device->bus_found && device->state != DG_CO_OFF)) {
            const enum dg_co_bus_event event = there ? DG_CO_BUS_PRESENT : DG_CO_BUS_ABSENT;
            note_deadline(node, dg_co_bus(&node->device, now, event));
            told = true;
        }
    }
    return told;
}

void lx_can_follow(struct lx_can_node *self, dg_ns now)
{
    struct dg_faults *faults = faults_of(self);
    enum dg_co_bus_event wanted = self->bus->state;
    if (dg_fault_wire_active(faults, DG_WIRE_BUS_OFF)) {
        wanted = DG_CO_BUS_OFF;
    } else if (wanted == DG_CO_BUS_ACTIVE && dg_fault_wire_active(faults, DG_WIRE_PASSIVE)) {
        wanted = DG_CO_BUS_PASSIVE;
    }
    if (self->device.state == DG_CO_OFF || wanted == state_of(&self->device)) {
        return;
    }
    /* The way from bus-off to passive leads over active. */
    if (self->device.bus_off && wanted == DG_CO_BUS_PASSIVE) {
        (void)dg_co_bus(&self->device, now, DG_CO_BUS_ACTIVE);
    }
    note_deadline(self, dg_co_bus(&self->device, now, wanted));
}

void lx_can_bend(struct lx_can_node *self, dg_ns now)
{
    const struct dg_faults *faults = faults_of(self);
    self->bent = faults->wire != 0 || self->held > 0;
    self->bus->bent = self->bus->bent || self->bent;
    if (self->device.state == DG_CO_OFF) {
        lx_can_answer_none(self);
    }
    lx_can_follow(self, now);
}
