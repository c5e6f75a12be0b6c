/* SPDX-License-Identifier: MIT */
/*
 * Many nodes on one bus: who listens to which CAN-ID.
 */
#include <string.h>

#include "drehgeber/canopen.h"

void dg_co_net_init(struct dg_co_net *self)
{
    memset(self, 0, sizeof *self);
}

bool dg_co_net_follow(struct dg_co_net *self, uint8_t i)
{
    struct dg_co_node *node = self->node[i];
    uint16_t ids[DG_CO_FILTERS_MAX];
    uint8_t bit = (uint8_t)(1u << (i % 8u));

    if (self->filter_version[i] == node->filter_version) {
        return false;
    }
    self->filter_version[i] = node->filter_version;
    for (uint16_t id = 0; id < DG_COUNT(self->listeners); id++) {
        self->listeners[id][i / 8u] &= (uint8_t)~bit;
    }
    for (uint8_t n = dg_co_filters(node, ids); n > 0; n--) {
        self->listeners[ids[n - 1u]][i / 8u] |= bit;
    }
    return true;
}

static void refresh(struct dg_co_net *self, uint8_t i, dg_ns deadline)
{
    self->deadline[i] = deadline;
    (void)dg_co_net_follow(self, i);
}

int dg_co_net_add(struct dg_co_net *self, struct dg_co_node *node)
{
    if (self->count == DG_CO_NET_NODES) {
        return DG_ERR_SPACE;
    }
    uint8_t i = self->count++;
    self->node[i] = node;
    self->filter_version[i] = (uint8_t)(node->filter_version - 1u);
    refresh(self, i, 0); /* the first step asks the node */
    return DG_OK;
}

static dg_ns next_deadline(const struct dg_co_net *self)
{
    dg_ns next = DG_NEVER;

    for (uint8_t i = 0; i < self->count; i++) {
        next = dg_earliest(next, self->deadline[i]);
    }
    return next;
}

dg_ns dg_co_net_rx(struct dg_co_net *self, dg_ns now, const struct dg_can_frame *frame)
{
    const uint8_t *listeners = self->listeners[frame->id & 0x7FFu];

    for (uint8_t byte = 0; byte < sizeof self->listeners[0]; byte++) {
        uint32_t bits = listeners[byte];
        for (uint8_t bit = 0; bits >> bit != 0; bit++) {
            if ((bits >> bit & 1u) != 0) {
                uint8_t i = (uint8_t)(8u * byte + bit);
                refresh(self, i, dg_co_rx(self->node[i], now, frame));
            }
        }
    }
    return next_deadline(self);
}

dg_ns dg_co_net_step(struct dg_co_net *self, dg_ns now)
{
    for (uint8_t i = 0; i < self->count; i++) {
        /* A node whose power was switched has no deadline here yet. */
        if (self->deadline[i] <= now || self->filter_version[i] != self->node[i]->filter_version) {
            refresh(self, i, dg_co_step(self->node[i], now));
        }
    }
    return next_deadline(self);
}

dg_ns dg_co_net_bus(struct dg_co_net *self, dg_ns now, enum dg_co_bus_event event)
{
    for (uint8_t i = 0; i < self->count; i++) {
        refresh(self, i, dg_co_bus(self->node[i], now, event));
    }
    return next_deadline(self);
}

bool dg_co_net_listens(const struct dg_co_net *self, uint16_t id)
{
    for (uint8_t byte = 0; byte < sizeof self->listeners[0]; byte++) {
        if (self->listeners[id & 0x7FFu][byte] != 0) {
            return true;
        }
    }
    return false;
}
