/* SPDX-License-Identifier: MIT */
/*
 * What faults make of a node's frames and of its controller: a layer around the node, which is
 * there only while it has any.
 *
 *   node -- bus-off? drop? damage? -- held back? -- emit
 *                            duplicate? --/
 *   offer -- bus-off? deaf? overrun? --> node
 */
#include "can_bus.h"
#include "drehgeber/instruments.h"

static struct dg_faults *faults_of(const struct lx_can_node *node)
{
    return &node->station->control.faults;
}

/* --- from a node --- */

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
            dg_after(waiting.at, (dg_ns)dg_fault_wire_value(&dg_cia406_instrument, DG_WIRE_DELAY));
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

static void send_bent(struct lx_can_node *from, const struct dg_can_frame *frame)
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

/* A frame that the controller had to drop is an event to the node. */
static bool overruns(struct lx_can_node *node, dg_ns now)
{
    const bool lost = dg_fault_wire_takes(faults_of(node), DG_WIRE_OVERRUN);
    if (lost) {
        lx_can_note_deadline(node, dg_co_bus(&node->device.node, now, DG_CO_BUS_OVERRUN));
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

static enum dg_co_bus_event state(const struct lx_can_node *node, enum dg_co_bus_event own)
{
    return (enum dg_co_bus_event)dg_fault_controller(faults_of(node), (enum dg_controller)own);
}

static const struct lx_can_layer layer = {
    .send = send_bent,
    .reaches = reaches,
    .state = state,
};

void lx_can_bend(struct lx_can_node *self, dg_ns now)
{
    const bool bent = faults_of(self)->wire != 0 || self->held > 0;
    self->bent = bent ? &layer : NULL;
    self->bus->bent = self->bus->bent || bent;
    if (self->device.node.state == DG_CO_OFF) {
        lx_can_answer_none(self);
    }
    lx_can_follow(self, now);
}
