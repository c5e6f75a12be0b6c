/* SPDX-License-Identifier: MIT */
/*
 * Frames between the nodes of a bus and its wire, and the state of the nodes' controllers:
 *
 *   node -- emit --> tap, wire, nodes that listen
 *   wire, other nodes -- offer --> node
 *
 * A node that is bent has a layer of faults between itself and this. The core must not be called
 * back while it sends, so what nodes send each other waits until it is through. The net's deadlines
 * are kept here as dg_co_net_rx() keeps them.
 */
#include "can_bus.h"

#include <stdlib.h>
#include <string.h>

#define LIST_FIRST 16u

bool lx_can_list_append(struct lx_can_list *self, const struct lx_can_waiting *frame)
{
    if (self->count == self->capacity) {
        const size_t capacity = self->capacity == 0 ? LIST_FIRST : 2 * self->capacity;
        struct lx_can_waiting *frames = realloc(self->frames, capacity * sizeof *frames);
        if (frames == NULL) {
            return false;
        }
        self->frames = frames;
        self->capacity = capacity;
    }
    self->frames[self->count++] = *frame;
    return true;
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
    const struct dg_tap_event event = {
        .at = self->tapped_at, .kind = DG_TAP_FRAME, .ours = ours, .frame = *frame};
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

void lx_can_put(struct lx_can_node *from, const struct dg_can_frame *frame)
{
    if (from->bent != NULL) {
        from->bent->send(from, frame);
    } else {
        lx_can_emit(from, frame);
    }
}

/* --- to a node --- */

void lx_can_note_deadline(struct lx_can_node *node, dg_ns deadline)
{
    if (node->index != LX_CAN_DEAF) {
        node->bus->net.deadline[node->index] = deadline;
    }
}

void lx_can_offer(struct lx_can_bus *self, dg_ns now, const struct dg_can_frame *frame,
                  const struct lx_can_node *from)
{
    for (uint8_t i = 0; i < self->net.count; i++) {
        struct lx_can_node *node = self->net.node[i]->setup.ctx;
        const bool listens = ((unsigned)self->net.listeners[frame->id][i / 8u] >> i % 8u & 1u) != 0;
        if (listens && node != from && (node->bent == NULL || node->bent->reaches(node, now))) {
            lx_can_note_deadline(node, dg_co_rx(&node->device.node, now, frame));
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

static bool has_bus(const struct lx_can_node *node)
{
    const struct lx_can *can = node->bus->can;
    return node->hears && can->ops->up(can) && can->company != LX_CAN_NOBODY;
}

/* The core is asked what it knows, as a power cycle may lie between two looks. */
bool lx_can_tell_presence(struct lx_can_bus *self, dg_ns now)
{
    bool told = false;
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        struct lx_can_node *node = &self->node[i];
        const struct dg_co_node *device = &node->device.node;
        const bool there = has_bus(node);
        const bool sure = there && self->can->company == LX_CAN_SOMEBODY;
        if (there == device->bus_absent ||
            (sure && !device->bus_found && device->state != DG_CO_OFF)) {
            const enum dg_co_bus_event event = there ? DG_CO_BUS_PRESENT : DG_CO_BUS_ABSENT;
            lx_can_note_deadline(node, dg_co_bus(&node->device.node, now, event));
            told = true;
        }
    }
    return told;
}

void lx_can_follow(struct lx_can_node *self, dg_ns now)
{
    const enum dg_co_bus_event own = self->bus->state;
    const enum dg_co_bus_event wanted = self->bent == NULL ? own : self->bent->state(self, own);
    lx_can_note_deadline(self, dg_co_controller(&self->device.node, now, wanted));
}
